#pragma once
/// The part of a board file that says how a real printer's devices are wired to its board: each key explained in board/README.md.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/settings/settings_file.hpp"

namespace plumbline {

/// [step_line], [cover_line], [start_button], ...: a GPIO line, by its name or by chip and offset.
struct WireFile {
  enum class Active : std::uint8_t { kHigh, kLow };
  enum class Bias : std::uint8_t { kAsIs, kDisabled, kPullUp, kPullDown };
  static constexpr std::uint32_t kNoOffset = 0xFFFFFFFF;

  std::string line;                  ///< as gpioinfo shows it; empty: by chip and offset
  std::string chip;                  ///< as gpiodetect shows it, name or label
  std::uint32_t offset = kNoOffset;  ///< on the chip
  Active active = Active::kHigh;     ///< the level that is on, up, pressed, open
  Bias bias = Bias::kAsIs;           ///< what the chip pulls the line to

  bool given() const { return !line.empty() || !chip.empty(); }
};

/// [lamp_sensor], [resin_sensor], [board_sensor]: in one of three ways.
struct SensorFile {
  std::string hwmon;          ///< name of the chip
  std::uint32_t channel = 1;  ///< of the chip
  std::string thermal_zone;   ///< type of the zone
  std::string file;           ///< with thousandths of a degree

  bool given() const { return !hwmon.empty() || !thermal_zone.empty() || !file.empty(); }
};

/// [lamp_fan], [chamber_fan]: in one of two ways.
struct FanFile {
  std::string hwmon;
  std::uint32_t channel = 1;
  std::string pwm_chip;
  std::uint32_t period_us = 40;
};

/// Everything that is absent from the file is empty here.
struct WiringFile {
  std::string card;                     ///< [display] empty: the one that has the connector
  std::string connector;                ///< [display]
  std::uint32_t refresh_hz = 0;         ///< [display] 0: any
  std::uint32_t plane = 0;              ///< [display] 0: the primary one
  std::uint32_t flip_timeout_ms = 500;  ///< [display]

  WireFile lamp, cover, step, direction, enable, end_stop;
  WireFile start, pause, cancel;
  std::array<WireFile, 4> lights;  ///< ready, printing, attention, fault
  WireFile buzzer;

  std::array<SensorFile, 3> sensors;  ///< lamp, resin, board
  std::array<FanFile, 2> fans;        ///< lamp, chamber

  std::string stick_port;  ///< [stick] empty: any
  std::string mount_point = "/run/plumbline/stick";

  /// Names of the tables without which no printer moves and lights, and that the file does not have.
  std::vector<std::string_view> missing() const;
};

/// The rules of all these tables, every key optional.
void add_wiring_rules(std::vector<SettingRule>& rules, WiringFile& wiring);

/// What is wrong with a key in view of the others of its table; empty: nothing.
std::string check_wiring(const SettingRule& rule, const WiringFile& wiring);

}  // namespace plumbline
