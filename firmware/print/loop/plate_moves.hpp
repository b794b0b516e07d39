#pragma once

#include <cstdint>
#include <optional>

#include "firmware/print/job/print_plan.hpp"
#include "firmware/print/loop/print_watch.hpp"

namespace plumbline::firmware {

/// Moves of the plate during a print. Each returns false if a request interrupted it; the plate has then stopped short.
/// Errors are those of ZStage.
class PlateMoves {
 public:
  /// All must outlive this.
  PlateMoves(ZStage& stage, const PrintPlan& plan, PrintWatch& watch) : stage_(stage), plan_(plan), watch_(watch) {}

  [[nodiscard]] Expected<bool> home();
  /// Lowers the plate from anywhere to where a layer is cured.
  [[nodiscard]] Expected<bool> lower_to(std::uint32_t layer);
  /// Peels a layer off the film.
  [[nodiscard]] Expected<bool> lift(std::uint32_t layer);
  /// Peels off whatever may stick to the film, then moves up to `to`. Does not move if the plate is already above it.
  [[nodiscard]] Expected<bool> raise(std::uint32_t layer, const StageMove& to);

  /// Found by the last home(): how far the stage was from where its steps said. 0: none lost.
  Distance steps_lost() const { return steps_lost_; }
  /// Where the last home() began; nothing if it did not arrive.
  std::optional<ZPosition> homed_from() const { return homed_from_; }
  void forget_steps_lost() { steps_lost_ = Distance(); }

 private:
  [[nodiscard]] Expected<bool> move(const StageMove& to);
  [[nodiscard]] Expected<bool> finish(Motion motion);

  ZStage& stage_;
  const PrintPlan& plan_;
  PrintWatch& watch_;
  Distance steps_lost_;
  std::optional<ZPosition> homed_from_;
};

}  // namespace plumbline::firmware
