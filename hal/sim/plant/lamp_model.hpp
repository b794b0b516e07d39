#pragma once
/// The lamp's light. It rises and falls linearly; the dose is the area below the curve.

#include <chrono>

#include "hal/clock.hpp"
#include "hal/units.hpp"

namespace plumbline::inline hal::inline sim {

class LampModel {
 public:
  /// @param irradiance  at level 1
  /// @param rise, fall  from level 0 to 1 and back; above 0
  LampModel(Irradiance irradiance, nanoseconds rise, nanoseconds fall)
      : irradiance_(irradiance), rise_(rise), fall_(fall) {}

  /// From `now` on the light approaches `level`.
  void drive(TimePoint now, double level);
  void set_rise(nanoseconds rise) { rise_ = rise; }

  double driven() const { return target_; }
  double level(TimePoint now) const { return level_after(now - mark_); }
  /// When the light reaches the driven level.
  TimePoint settles_at() const;
  /// Dose since the last call.
  Dose take_dose(TimePoint now);

 private:
  double level_after(nanoseconds time) const;
  double seconds_to_target() const;
  /// Integrates up to `now`.
  void mark(TimePoint now);

  Irradiance irradiance_;
  nanoseconds rise_;
  nanoseconds fall_;
  TimePoint mark_;
  double level_ = 0;   ///< at mark_
  double target_ = 0;  ///< driven level
  double area_ = 0;    ///< integral of the level until mark_, s
};

}  // namespace plumbline::inline hal::inline sim
