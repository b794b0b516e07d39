#pragma once

#include "hal/sim/plant.hpp"
#include "hal/z_stage.hpp"

namespace plumbline {

/// The plant's stage: counts steps, and finds its end stop.
class SimZStage final : public ZStage {
 public:
  SimZStage(Plant& plant, Interlock& interlock);
  ~SimZStage() override;

 private:
  /// The legs of homing, in order.
  enum class Phase : std::uint8_t { kMove, kRelease, kApproach, kBackOff, kFind, kReturn };

  bool do_homed() const override;
  bool do_moving() const override;
  bool do_end_stop_pressed() const override;
  ZPosition do_position() const override;
  Status do_begin_homing() override;
  Status do_begin_move(ZPosition target, Speed speed) override;
  TimePoint do_ends_by() const override;
  Status do_stop() override;
  Expected<MotionReport> do_finish() override;

  void start(Phase phase, Distance way, Speed speed, StageSwitch until);
  void on_rest(const LegResult& leg);
  void home_further(const LegResult& leg);
  void found(const LegResult& leg);
  void rest(bool arrived, ErrorCode problem, const char* message);

  Plant& plant_;
  Phase phase_ = Phase::kMove;
  bool moving_ = false;
  bool stopping_ = false;
  bool homed_ = false;
  bool was_homed_ = false;  ///< before the homing that runs
  ZPosition at_;            ///< by the steps counted, at rest
  TimePoint ends_by_;
  MotionReport report_;
  bool failed_ = false;
  Error problem_;
};

}  // namespace plumbline
