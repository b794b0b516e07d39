#pragma once
/// Temperatures: the lamp warms while it is lit, its fan cools it, and everything else stays constant.

#include <array>
#include <optional>

#include "hal/clock.hpp"
#include "hal/thermals.hpp"

namespace plumbline::inline hal::inline sim {

/// First order: the lamp approaches room temperature when off, 25 degrees above when lit with its fan, 60 without, with a time
/// constant of 90 s. Plausible figures, not measured ones: with its fan the lamp stays below lamp_max_c of board/sim2k.toml, without it does not.
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

}  // namespace plumbline::inline hal::inline sim
