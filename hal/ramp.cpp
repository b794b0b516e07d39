#include "hal/ramp.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace plumbline::inline hal {

Ramp::Ramp(Distance distance, Speed speed, Acceleration acceleration) : acceleration_(acceleration.value()) {
  const double distance_mm = distance.millimetres();
  assert(distance_mm >= 0 && speed.value() > 0 && acceleration_ > 0);
  peak_ = std::min(speed.value(), std::sqrt(distance_mm * acceleration_));
  accelerating_ = peak_ / acceleration_;
  if (peak_ > 0) cruising_ = std::max(0.0, distance_mm / peak_ - accelerating_);
}

double Ramp::travelled_mm(Seconds time) const {
  const double t = std::clamp(time.count(), 0.0, duration().count());
  if (t <= accelerating_) return 0.5 * acceleration_ * t * t;
  if (t <= accelerating_ + cruising_) return peak_ * (t - 0.5 * accelerating_);
  const double left = duration().count() - t;
  return length_mm() - 0.5 * acceleration_ * left * left;
}

Ramp::Seconds Ramp::time_at_mm(double distance_mm) const {
  if (distance_mm <= 0) return Seconds(0);
  if (distance_mm >= length_mm()) return duration();
  const double speeding_up = 0.5 * peak_ * accelerating_;  // mm covered in each of the two slopes
  if (distance_mm <= speeding_up) return Seconds(std::sqrt(2 * distance_mm / acceleration_));
  if (distance_mm <= length_mm() - speeding_up) return Seconds(distance_mm / peak_ + 0.5 * accelerating_);
  return Seconds(duration().count() - std::sqrt(2 * (length_mm() - distance_mm) / acceleration_));
}

Speed Ramp::speed_at(Seconds time) const {
  const double t = time.count();
  const double end = duration().count();
  if (t <= 0 || t >= end) return Speed(0);
  return Speed(std::min({acceleration_ * t, peak_, acceleration_ * (end - t)}));
}

Ramp Ramp::stopped_at(Seconds time) const {
  const double t = std::max(0.0, time.count());
  Ramp stopped = *this;
  if (t < accelerating_) {
    stopped.accelerating_ = t;
    stopped.peak_ = acceleration_ * t;
    stopped.cruising_ = 0;
  } else if (t < accelerating_ + cruising_) {
    stopped.cruising_ = t - accelerating_;
  }
  return stopped;
}

}  // namespace plumbline::inline hal
