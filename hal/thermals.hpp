#pragma once
/// Temperature sensors and fans.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "hal/interlock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

/// Where a temperature is measured.
enum class TemperatureSite : std::uint8_t {
  kLamp,   ///< the LEDs' heat sink
  kResin,  ///< the tank, or the air beside it
  kBoard,  ///< the processor
};
inline constexpr std::size_t kTemperatureSiteCount = 3;

/// "lamp", "resin", "board".
std::string_view to_string(TemperatureSite site);

enum class Fan : std::uint8_t {
  kLamp,     ///< blows over the LEDs' heat sink
  kChamber,  ///< extracts vapour
};
inline constexpr std::size_t kFanCount = 2;

/// "lamp", "chamber".
std::string_view to_string(Fan fan);

enum class FanHealth : std::uint8_t {
  kOk,            ///< turns if it should
  kStalled,       ///< should turn, but doesn't
  kNotMonitored,  ///< the fan has no tachometer
};

/// A reading outside of these is a broken or unplugged sensor: no printer runs that cold or that hot.
inline constexpr Celsius kColdestReading(-30);
inline constexpr Celsius kHottestReading(150);

class Thermals {
 public:
  Thermals(const Thermals&) = delete;
  Thermals& operator=(const Thermals&) = delete;
  virtual ~Thermals() = default;

  /// A temperature at most 2 s old.
  /// @retval ErrorCode::kSensorDead  no answer, or outside kColdestReading to kHottestReading
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<Celsius> temperature(TemperatureSite site) const;

  /// @param duty  share of full power, clamped to 0 to 1
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status set_fan(Fan fan, double duty);

  /// A fan has 2 s to spin up, during which it counts as kOk.
  FanHealth fan_health(Fan fan) const { return do_fan_health(fan); }

 protected:
  explicit Thermals(Interlock& interlock) : interlock_(interlock) {}

 private:
  virtual Expected<Celsius> do_temperature(TemperatureSite site) const = 0;
  virtual Status do_set_fan(Fan fan, double duty) = 0;
  virtual FanHealth do_fan_health(Fan fan) const = 0;

  Interlock& interlock_;
};

}  // namespace plumbline::inline hal
