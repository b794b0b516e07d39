#pragma once

#include <optional>

#include "hal/sim/plant/plant.hpp"
#include "hal/z_stage.hpp"

namespace plumbline::inline hal::inline sim {

/// The plant's stage. Counts steps and homes at its end stop.
class SimZStage final : public ZStage {
 public:
  SimZStage(Plant& plant, Interlock& interlock);
  ~SimZStage() override;

 private:
  /// A move, a jog, and the legs of homing in order.
  enum class Phase : std::uint8_t { kMove, kJog, kRelease, kApproach, kBackOff, kFind, kReturn };

  bool do_homed() const override;
  bool do_moving() const override;
  bool do_end_stop_pressed() const override;
  ZPosition do_position() const override;
  Status do_begin_homing() override;
  Status do_begin_move(ZPosition target, Speed speed) override;
  Status do_begin_jog(Distance distance, Speed speed) override;
  TimePoint do_ends_by() const override;
  Status do_stop() override;
  Expected<MotionReport> do_finish() override;

  void begin_report();
  /// True travel for what the firmware asks, and back.
  Distance built(Distance asked) const;
  Distance counted(Distance travel) const;
  void start(Phase phase, Distance distance, Speed speed, StageSwitch until);
  void on_rest(const LegResult& leg);
  void continue_homing(const LegResult& leg);
  void on_end_stop_found(const LegResult& leg);
  void finish_motion(bool arrived);
  void fail_motion(const Error& problem);

  Plant& plant_;
  Phase phase_ = Phase::kMove;
  bool moving_ = false;
  bool stopping_ = false;
  bool homed_ = false;
  bool was_homed_ = false;  ///< before the homing that runs
  ZPosition position_;      ///< at rest, by counted steps
  ZPosition homed_from_;    ///< position_ before the homing that runs
  ZPosition began_at_height_;
  TimePoint ends_by_;
  MotionReport report_;
  std::optional<Error> problem_;  ///< of the last motion
};

}  // namespace plumbline::inline hal::inline sim
