#pragma once

#include "hal/sim/plant.hpp"
#include "hal/uv_lamp.hpp"

namespace plumbline {

/// The plant's lamp, with the keeper that a board has in a process of its own: it ends every exposure, watches the cover, and cuts
/// the lamp's supply when there is light without its line.
class SimUvLamp final : public UvLamp {
 public:
  static constexpr auto kCoverReaction = std::chrono::milliseconds(2);
  static constexpr auto kStuckAfter = std::chrono::milliseconds(10);  ///< light without the line

  SimUvLamp(Plant& plant, Interlock& interlock, Clock& clock);
  /// The keeper sees that the firmware is gone.
  ~SimUvLamp() override;

  void cover_opened();
  void power_lost() { off(ExposureEnd::kStopped); }

 private:
  Expected<TimePoint> do_begin(nanoseconds cure) override;
  bool do_over() const override;
  void do_darken() noexcept override;
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

}  // namespace plumbline
