#include "firmware/print/loop/plate_moves.hpp"

#include <algorithm>
#include <utility>

namespace plumbline::firmware {

Expected<bool> PlateMoves::finish(Motion motion) {
  const auto over = watch_.wait_for(motion);
  PLUMBLINE_TRY(over);
  if (!*over) PLUMBLINE_TRY(motion.stop());
  const auto report = motion.finish();
  PLUMBLINE_TRY(report);
  if (report->steps_lost != Distance()) steps_lost_ = report->steps_lost;
  if (report->began_at_height) homed_from_ = report->began_at_height;
  return report->arrived && !watch_.interrupted();
}

Expected<bool> PlateMoves::home() {
  auto motion = stage_.begin_homing();
  PLUMBLINE_TRY(motion);
  return finish(std::move(*motion));
}

Expected<bool> PlateMoves::move(const StageMove& to) {
  const auto at = stage_.position();
  PLUMBLINE_TRY(at);
  // Less than a microstep (1.25 um on sim2k): the stage rounds, so there is nothing to move.
  constexpr Distance kNoMove = Distance::nanometres(100);
  if (*at - to.target < kNoMove && to.target - *at < kNoMove) return !watch_.interrupted();
  auto motion = stage_.begin_move(to.target, to.speed);
  PLUMBLINE_TRY(motion);
  return finish(std::move(*motion));
}

Expected<bool> PlateMoves::lower_to(std::uint32_t layer) {
  const auto down = retract_to(plan_, layer);
  const auto at = stage_.position();
  PLUMBLINE_TRY(at);
  // After a pause or from the top, go fast to where the lift of a layer ends.
  const ZPosition near = std::min(down[1].target + plan_.lift + plan_.lift2, plan_.highest);
  if (*at > near) {
    const auto moved = move({near, plan_.fastest});
    if (!moved || !*moved) return moved;
  }
  for (const auto& leg : down) {
    const auto moved = move(leg);
    if (!moved || !*moved) return moved;
  }
  return true;
}

Expected<bool> PlateMoves::lift(std::uint32_t layer) {
  for (const auto& leg : lift_from(plan_, layer)) {
    const auto moved = move(leg);
    if (!moved || !*moved) return moved;
  }
  return true;
}

Expected<bool> PlateMoves::raise(std::uint32_t layer, const StageMove& to) {
  const auto at = stage_.position();
  PLUMBLINE_TRY(at);
  if (*at >= to.target) return !watch_.interrupted();
  if (*at < height_of(plan_, layer) + plan_.lift) {
    const auto peeled = move({std::min(*at + plan_.lift, to.target), plan_.lift_speed});
    if (!peeled || !*peeled) return peeled;
  }
  return move(to);
}

}  // namespace plumbline::firmware
