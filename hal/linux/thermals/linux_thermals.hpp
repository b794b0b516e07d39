#pragma once
/// Temperatures and fans of a board, through sysfs.

#include <optional>

#include "hal/linux/events/linux_clock.hpp"
#include "hal/linux/thermals/number_file.hpp"
#include "hal/linux/thermals/thermal_settings.hpp"

namespace plumbline {

/// The file that holds a sensor's temperature.
/// @param sysfs  "/sys"
/// @retval ErrorCode::kBadSetting  no chip or zone of that name: those that there are
[[nodiscard]] Expected<std::string> find_sensor(const SensorSettings& settings, const std::string& sysfs);

/// The file that sets a fan's speed: of a hwmon chip, or the folder of a PWM chip, whose channels come when they are asked for.
/// @retval ErrorCode::kBadSetting  no such chip
[[nodiscard]] Expected<std::string> find_fan(const FanSettings& settings, const std::string& sysfs);

/// A fan whose speed is set by pulses.
class LinuxFan {
 public:
  /// Takes it over from the kernel, standing. @pre settings.given()
  /// @retval ErrorCode::kBadSetting  no such chip
  /// @retval ErrorCode::kCannotOpen  no permission, or another program has the channel
  [[nodiscard]] static Expected<LinuxFan> open(const FanSettings& settings, const std::string& sysfs);

  /// @param duty  0 to 1
  [[nodiscard]] bool set(double duty) noexcept;
  FanHealth health() const noexcept;

 private:
  LinuxFan(NumberFile duty, std::int64_t full, std::optional<NumberFile> turns)
      : duty_(std::move(duty)), full_(full), turns_(std::move(turns)) {}
  NumberFile duty_;
  std::int64_t full_;                // what it is at full speed
  std::optional<NumberFile> turns_;  // a minute; absent: the fan has no wire that tells
  bool asked_ = false;
  nanoseconds asked_at_{};
};

class LinuxThermals final : public Thermals {
 public:
  struct Devices {
    std::array<std::optional<NumberFile>, kTemperatureSiteCount> sensors;
    std::array<std::optional<LinuxFan>, kFanCount> fans;
  };
  /// @param sysfs  "/sys"
  /// @retval those of find_sensor() and LinuxFan::open(), with the sensor's or the fan's name
  [[nodiscard]] static Expected<Devices> open(const ThermalSettings& settings, const std::string& sysfs);

  LinuxThermals(Devices devices, Interlock& interlock) : Thermals(interlock), devices_(std::move(devices)) {}

 private:
  Expected<Celsius> do_temperature(TemperatureSite site) const override;
  Status do_set_fan(Fan fan, double duty) override;
  FanHealth do_fan_health(Fan fan) const override;

  Devices devices_;
};

}  // namespace plumbline
