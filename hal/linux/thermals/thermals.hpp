#pragma once
/// Temperature sensors and fans of a board, through sysfs.

#include <optional>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/thermals/number_file.hpp"
#include "hal/wiring.hpp"

namespace plumbline::inline hal::inline linux_board {

/// The path of a sensor's file.
/// @param sysfs  "/sys"
/// @retval ErrorCode::kBadSetting  no chip or zone of that name; the message lists the others
[[nodiscard]] Expected<std::string> find_sensor(const SensorSettings& settings, const std::string& sysfs);

/// The path of the file that controls a fan: pwm1 of a hwmon chip, or "export" of a PWM chip, which creates its channels.
/// @retval ErrorCode::kBadSetting  no such chip
[[nodiscard]] Expected<std::string> find_fan(const FanSettings& settings, const std::string& sysfs);

/// A fan with PWM speed control.
class LinuxFan {
 public:
  /// Takes control of the fan from the kernel and stops it. @pre settings.given()
  /// @retval ErrorCode::kBadSetting  no such chip
  /// @retval ErrorCode::kCannotOpen  no permission, or another program has the channel
  [[nodiscard]] static Expected<LinuxFan> open(const FanSettings& settings, const std::string& sysfs);

  /// @param duty  0 to 1
  [[nodiscard]] bool set(double duty) noexcept;
  FanHealth health() const noexcept;

 private:
  LinuxFan(NumberFile duty, std::int64_t full, std::optional<NumberFile> tachometer)
      : duty_(std::move(duty)), full_(full), tachometer_(std::move(tachometer)) {}
  NumberFile duty_;
  std::int64_t full_;                     // the value at full speed
  std::optional<NumberFile> tachometer_;  // revolutions a minute; absent: the fan has no tachometer
  bool on_ = false;
  nanoseconds turned_on_at_{};  // CLOCK_MONOTONIC
};

class LinuxThermals final : public Thermals {
 public:
  struct Devices {
    std::array<std::optional<NumberFile>, kTemperatureSiteCount> sensors;
    std::array<std::optional<LinuxFan>, kFanCount> fans;
  };
  /// @param sysfs  "/sys"
  /// @retval the errors of find_sensor() and LinuxFan::open(), with the name of the sensor or fan
  [[nodiscard]] static Expected<Devices> open(const ThermalSettings& settings, const std::string& sysfs);

  LinuxThermals(Devices devices, Interlock& interlock) : Thermals(interlock), devices_(std::move(devices)) {}

 private:
  Expected<Celsius> do_temperature(TemperatureSite site) const override;
  Status do_set_fan(Fan fan, double duty) override;
  FanHealth do_fan_health(Fan fan) const override;

  Devices devices_;
};

}  // namespace plumbline::inline hal::inline linux_board
