#include "hal/z_stage.hpp"

#include <algorithm>
#include <cassert>

namespace plumbline::inline hal {

Motion::~Motion() {
  if (stage_ == nullptr || !stage_->moving()) return;
  // Both fail only when the power is lost, and then nothing moves.
  static_cast<void>(stage_->do_stop());
  static_cast<void>(stage_->do_finish());
}

TimePoint Motion::ends_by() const {
  assert(stage_ != nullptr && "finish() was already called");
  return stage_->do_ends_by();
}

bool Motion::over() const {
  assert(stage_ != nullptr && "finish() was already called");
  return !stage_->moving();
}

Status Motion::stop() {
  assert(stage_ != nullptr && "finish() was already called");
  PLUMBLINE_TRY(stage_->interlock_.check_power());
  return stage_->do_stop();
}

Expected<MotionReport> Motion::finish() {
  assert(stage_ != nullptr && "finish() was already called");
  ZStage& stage = *std::exchange(stage_, nullptr);
  PLUMBLINE_TRY(stage.interlock_.check_power());
  return stage.do_finish();
}

Expected<ZPosition> ZStage::position() const {
  PLUMBLINE_TRY(interlock_.check_power());
  if (!homed()) return fail(ErrorCode::kNotHomed, "the stage is not homed, so its height is unknown: home it first");
  return do_position();
}

Expected<Motion> ZStage::begin_homing() {
  PLUMBLINE_TRY(interlock_.check_power());
  if (moving()) return fail(ErrorCode::kBusy, "the stage is already moving");
  if (interlock_.lamp_lit()) return fail(ErrorCode::kLampLit, "the stage does not move while the lamp is lit");
  PLUMBLINE_TRY(do_begin_homing());
  return Motion(*this);
}

Expected<Motion> ZStage::begin_move(ZPosition target, Speed speed) {
  PLUMBLINE_TRY(interlock_.check_power());
  if (moving()) return fail(ErrorCode::kBusy, "the stage is already moving");
  if (target < limits_.lowest || target > limits_.highest) {
    return fail(ErrorCode::kOutsideTravel, "a move to %.4f mm: the stage travels from %.4f to %.4f mm",
                target.above_film().millimetres(), limits_.lowest.above_film().millimetres(),
                limits_.highest.above_film().millimetres());
  }
  if (!(speed.value() > 0) || speed > limits_.fastest) {
    return fail(ErrorCode::kBadSetting, "a move at %g mm/s: the speed must be above 0 and at most %g mm/s",
                speed.value(), limits_.fastest.value());
  }
  if (!homed()) return fail(ErrorCode::kNotHomed, "the stage is not homed, so its height is unknown: home it first");
  if (interlock_.lamp_lit()) return fail(ErrorCode::kLampLit, "the stage does not move while the lamp is lit");
  PLUMBLINE_TRY(do_begin_move(target, speed));
  return Motion(*this);
}

Expected<Motion> ZStage::begin_jog(Distance distance) {
  // Slow enough for a motor whose step is sixteen times as long as the board file says, and for a person with a hand on the switch.
  constexpr Speed kJogSpeed(1);
  PLUMBLINE_TRY(interlock_.check_power());
  if (moving()) return fail(ErrorCode::kBusy, "the stage is already moving");
  if (distance == Distance() || distance > kLongestJog || distance < -kLongestJog) {
    return fail(ErrorCode::kOutsideTravel, "a jog by %.4f mm: allowed is up to %.0f mm up or down",
                distance.millimetres(), kLongestJog.millimetres());
  }
  if (interlock_.lamp_lit()) return fail(ErrorCode::kLampLit, "the stage does not move while the lamp is lit");
  if (end_stop_pressed()) {
    return fail(
        ErrorCode::kEndStopStuck,
        "the end stop is pressed:\tturn the screw by hand until it is free, or correct active of [end_stop_line]");
  }
  PLUMBLINE_TRY(do_begin_jog(distance, std::min(kJogSpeed, limits_.fastest)));
  return Motion(*this);
}

Expected<MotionReport> ZStage::home() {
  auto motion = begin_homing();
  if (!motion) return tl::unexpected<Error>(motion.error());
  return motion->finish();
}

Expected<MotionReport> ZStage::move_to(ZPosition target, Speed speed) {
  auto motion = begin_move(target, speed);
  if (!motion) return tl::unexpected<Error>(motion.error());
  return motion->finish();
}

}  // namespace plumbline::inline hal
