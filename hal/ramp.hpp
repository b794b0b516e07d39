#pragma once
/// The trapezoidal ramp of every move of the stage: times the steps, and predicts how long a move takes.

#include <chrono>

#include "hal/units.hpp"

namespace plumbline::inline hal {

/// Speeds up with constant acceleration, cruises, and brakes with the same acceleration to stop at the given distance.
///
///   v^2 / a <  d    trapezoid:  T = d / v + v / a
///   v^2 / a >= d    triangle:   T = 2 sqrt(d / a), the cruising speed v is never reached (peak sqrt(d a))
///
/// Times are seconds since the start of the move; distances are covered millimetres and never negative.
class Ramp {
 public:
  using Seconds = std::chrono::duration<double>;

  Ramp() = default;
  /// @param distance      0 or more
  /// @param speed         cruising speed, above 0
  /// @param acceleration  above 0
  Ramp(Distance distance, Speed speed, Acceleration acceleration);

  Seconds duration() const { return Seconds(2 * accelerating_ + cruising_); }
  Speed peak() const { return Speed(peak_); }
  double length_mm() const { return peak_ * (accelerating_ + cruising_); }

  /// Distance covered at `time`, mm: 0 before the start, length_mm() after the end.
  double travelled_mm(Seconds time) const;
  /// When `distance_mm` is covered, or duration() if it never is. Inverse of travelled_mm().
  Seconds time_at_mm(double distance_mm) const;
  Speed speed_at(Seconds time) const;

  /// The same ramp, but braking from `time` on.
  Ramp stopped_at(Seconds time) const;

 private:
  double acceleration_ = 1;  // mm/s^2
  double peak_ = 0;          // mm/s
  double accelerating_ = 0;  // s; braking takes as long
  double cruising_ = 0;      // s
};

}  // namespace plumbline::inline hal
