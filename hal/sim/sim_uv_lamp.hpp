#pragma once

#include "hal/sim/plant/plant.hpp"
#include "hal/uv_lamp.hpp"

namespace plumbline::inline hal::inline sim {

/// The plant's lamp, with the keeper that is a separate process on a board. The keeper ends every exposure, watches the cover, and
/// cuts the lamp's supply if there is light while the line is off.
class SimUvLamp final : public UvLamp {
 public:
  static constexpr auto kCoverReaction = std::chrono::milliseconds(2);  ///< any value below the promised 10 ms
  /// Light this long after the line went off means that the lamp is stuck: well above lamp_fall, 1 ms.
  static constexpr auto kStuckAfter = std::chrono::milliseconds(10);

  SimUvLamp(Plant& plant, Interlock& interlock, Clock& clock);
  /// Turns the lamp off, as the keeper does when the firmware is gone.
  ~SimUvLamp() override;

  void cover_opened();
  void power_lost() { off(ExposureEnd::kStopped); }

 private:
  Expected<TimePoint> do_begin(nanoseconds cure) override;
  bool do_over() const override;
  void do_turn_off() noexcept override;
  bool do_lit() const override;
  Expected<ExposureReport> do_report() override;
  void off(ExposureEnd end);

  Plant& plant_;
  bool on_ = false;
  bool supply_cut_ = false;
  ExposureReport report_;
  Timeline::Due deadline_;
  Timeline::Due cover_;
  Timeline::Due watch_;
};

}  // namespace plumbline::inline hal::inline sim
