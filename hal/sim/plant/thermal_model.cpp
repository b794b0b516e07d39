#include "hal/sim/plant/thermal_model.hpp"

#include <cmath>

namespace plumbline::inline hal::inline sim {
namespace {

std::size_t index(TemperatureSite site) { return static_cast<std::size_t>(site); }
std::size_t index(Fan fan) { return static_cast<std::size_t>(fan); }

}  // namespace

bool ThermalModel::lamp_cooled() const { return duty_[index(Fan::kLamp)] > 0 && !stalled_[index(Fan::kLamp)]; }

double ThermalModel::lamp_at(TimePoint now) const {
  const double goal = room_.value() + (!lit_ ? 0 : lamp_cooled() ? 25 : 60);  // see ThermalModel
  const double time = std::chrono::duration<double>(now - mark_).count();
  return goal + (lamp_ - goal) * std::exp(-time / 90);
}

void ThermalModel::mark(TimePoint now) {
  lamp_ = lamp_at(now);
  mark_ = now;
}

void ThermalModel::set_lit(TimePoint now, bool lit) {
  mark(now);
  lit_ = lit;
}

void ThermalModel::set_fan(TimePoint now, Fan fan, double duty) {
  mark(now);
  duty_[index(fan)] = duty;
}

void ThermalModel::set_stalled(TimePoint now, Fan fan, bool stalled) {
  mark(now);
  stalled_[index(fan)] = stalled;
}

Celsius ThermalModel::temperature(TimePoint now, TemperatureSite site) const {
  if (forced[index(site)]) return Celsius(*forced[index(site)]);
  switch (site) {
    case TemperatureSite::kLamp: return Celsius(lamp_at(now));
    case TemperatureSite::kResin: return room_;
    case TemperatureSite::kBoard: return room_ + Celsius(20);
  }
  return room_;
}

FanHealth ThermalModel::fan_health(Fan fan) const {
  return duty_[index(fan)] > 0 && stalled_[index(fan)] ? FanHealth::kStalled : FanHealth::kOk;
}

}  // namespace plumbline::inline hal::inline sim
