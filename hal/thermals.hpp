#pragma once
/// Temperature sensors and fans.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "hal/interlock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// Where a temperature is taken.
enum class TemperatureSite : std::uint8_t {
  kLamp,   ///< the LEDs' heat sink
  kResin,  ///< the vat, or the air beside it
  kBoard,  ///< the processor
};
inline constexpr std::size_t kTemperatureSiteCount = 3;

/// "lamp", "resin", "board".
std::string_view to_string(TemperatureSite site);

enum class Fan : std::uint8_t {
  kLamp,     ///< blows over the LEDs' heat sink
  kChamber,  ///< draws vapour out
};
inline constexpr std::size_t kFanCount = 2;

/// "lamp", "chamber".
std::string_view to_string(Fan fan);

enum class FanHealth : std::uint8_t {
  kAsAsked,       ///< turns when it is to turn
  kStalled,       ///< does not, although it is to
  kNotMonitored,  ///< the fan has no wire that tells
};

class Thermals {
 public:
  Thermals(const Thermals&) = delete;
  Thermals& operator=(const Thermals&) = delete;
  virtual ~Thermals() = default;

  /// A recent temperature, not older than 2 s.
  /// @retval ErrorCode::kSensorDead  no answer, or one that no printer can have (below -30 or above 150 degrees)
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<Celsius> temperature(TemperatureSite site) const;

  /// @param duty  0 to 1, clamped
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status set_fan(Fan fan, double duty);

  /// A fan that has been asked to turn less than 2 s ago is kAsAsked.
  FanHealth fan_health(Fan fan) const { return do_fan_health(fan); }

 protected:
  explicit Thermals(Interlock& interlock) : interlock_(interlock) {}

 private:
  virtual Expected<Celsius> do_temperature(TemperatureSite site) const = 0;
  virtual Status do_set_fan(Fan fan, double duty) = 0;
  virtual FanHealth do_fan_health(Fan fan) const = 0;

  Interlock& interlock_;
};

}  // namespace plumbline
