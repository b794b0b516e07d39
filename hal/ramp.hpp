#pragma once
/// The trapezoidal ramp that every move of the stage follows: for back ends that step it, and for whoever wants to know how long
/// a move takes.

#include <chrono>

#include "hal/units.hpp"

namespace plumbline {

/// Speeds up with constant acceleration, cruises, slows down with the same acceleration to stand at the distance asked for.
///
///   v^2 / a <  d    trapezoid:  T = d / v + v / a
///   v^2 / a >= d    triangle:   T = 2 sqrt(d / a), the cruising speed v is never reached (peak sqrt(d a))
///
/// Times are seconds since the start of the move, distances are along the way and not negative.
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
  /// The way in all, mm.
  double length_mm() const { return peak_ * (accelerating_ + cruising_); }

  /// The way covered at `time`, mm; 0 before the start, length_mm() after the end.
  double travelled_mm(Seconds time) const;
  /// When that much of the way is covered; duration() where it never is. The inverse of travelled_mm().
  Seconds time_at_mm(double way) const;
  Speed speed_at(Seconds time) const;

  /// The ramp that slows down from `time` on: same until then, shorter after it.
  Ramp stopped_at(Seconds time) const;

 private:
  double acceleration_ = 1;  // mm/s^2
  double peak_ = 0;          // mm/s
  double accelerating_ = 0;  // s, and as long slowing down
  double cruising_ = 0;      // s
};

}  // namespace plumbline
