#pragma once
/// Where a board's temperatures and fans are: as the board file has it.

#include <array>
#include <cstdint>
#include <string>

#include "hal/thermals.hpp"

namespace plumbline {

/// One of the three ways; the others are empty.
struct SensorSettings {
  std::string hwmon;  ///< the chip's name in /sys/class/hwmon/*/name, as "lm75"; its numbers change with each start
  std::uint32_t channel = 1;  ///< temp1_input, ...
  std::string thermal_zone;   ///< the zone's type, as "cpu-thermal"
  std::string file;           ///< of thousandths of a degree, as a 1-wire sensor's "temperature"

  bool given() const { return !hwmon.empty() || !thermal_zone.empty() || !file.empty(); }
};

/// One of the two ways, or none: the printer does not have it.
struct FanSettings {
  std::string hwmon;             ///< the chip's name; pwm1 and, where it is there, fan1_input
  std::uint32_t channel = 1;     ///< of the chip or of pwm_chip, where it counts from 0
  std::string pwm_chip;          ///< "pwmchip0"
  std::uint32_t period_us = 40;  ///< of pwm_chip: 25 kHz is what fans of four wires want

  bool given() const { return !hwmon.empty() || !pwm_chip.empty(); }
};

struct ThermalSettings {
  std::array<SensorSettings, kTemperatureSiteCount> sensors;  ///< by TemperatureSite
  std::array<FanSettings, kFanCount> fans;                    ///< by Fan
};

}  // namespace plumbline
