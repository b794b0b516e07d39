#pragma once
/// Temperatures: the lamp warms while it is lit and its fan cools it, the rest keeps its own.

#include <array>
#include <optional>

#include "hal/clock.hpp"
#include "hal/thermals.hpp"

namespace plumbline {

/// First-order: the lamp goes towards room + 25 degrees when lit with its fan, + 60 without, room when dark, each with a time
/// constant of 90 s.
class ThermalModel {
 public:
  explicit ThermalModel(Celsius room) : room_(room), lamp_(room.value()) {}

  void set_lit(TimePoint now, bool lit);
  void set_fan(TimePoint now, Fan fan, double duty);
  Celsius temperature(TimePoint now, TemperatureSite site) const;
  FanHealth fan_health(Fan fan) const;

  // Faults.
  std::array<bool, kTemperatureSiteCount> dead{};
  std::array<std::optional<double>, kTemperatureSiteCount> forced{};  ///< degrees
  void set_stalled(TimePoint now, Fan fan, bool stalled);

 private:
  double lamp_at(TimePoint now) const;
  bool lamp_cooled() const;
  void mark(TimePoint now);

  Celsius room_;
  TimePoint mark_;
  double lamp_;  ///< at mark_
  bool lit_ = false;
  std::array<double, kFanCount> duty_{};
  std::array<bool, kFanCount> stalled_{};
};

}  // namespace plumbline
