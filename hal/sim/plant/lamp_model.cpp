#include "hal/sim/plant/lamp_model.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline hal::inline sim {
namespace {

double seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

double LampModel::seconds_to_target() const {
  return std::abs(target_ - level_) * seconds(target_ > level_ ? rise_ : fall_);
}

double LampModel::level_after(nanoseconds time) const {
  const double whole = seconds_to_target();
  const double part = seconds(time);
  return part >= whole ? target_ : level_ + (target_ - level_) * part / whole;
}

TimePoint LampModel::settles_at() const {
  return mark_ + nanoseconds(static_cast<nanoseconds::rep>(std::ceil(seconds_to_target() * 1e9)));
}

void LampModel::mark(TimePoint now) {
  const double time = seconds(now - mark_);
  const double sloping = std::min(time, seconds_to_target());
  const double level_now = level_after(now - mark_);
  area_ += 0.5 * (level_ + level_now) * sloping + target_ * (time - sloping);
  level_ = level_now;
  mark_ = now;
}

void LampModel::drive(TimePoint now, double level) {
  mark(now);
  target_ = level;
}

Dose LampModel::take_dose(TimePoint now) {
  mark(now);
  const Dose dose(irradiance_.value() * area_);
  area_ = 0;
  return dose;
}

}  // namespace plumbline::inline hal::inline sim
