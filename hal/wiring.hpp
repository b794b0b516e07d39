#pragma once
/// Where a board's devices are: the part of a board file that only a real printer needs. board/README.md explains each key.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "hal/front_panel.hpp"
#include "hal/thermals.hpp"

namespace plumbline::inline hal {

/// What the chip pulls an input to while nothing drives it.
enum class LineBias : std::uint8_t {
  kAsIs,      ///< unchanged: the board's firmware or device tree sets it
  kDisabled,  ///< floating: the board has its own resistor
  kPullUp,
  kPullDown,
};
/// Words of the board file and of the keeper's command line, in the order of LineBias.
inline constexpr std::array<std::string_view, 4> kLineBiasWords = {"as-is", "disabled", "pull-up", "pull-down"};

/// [lamp_line], [start_button], [buzzer], ...: a GPIO line, given by its name or by chip and offset.
struct LineSettings {
  static constexpr std::uint32_t kNoOffset = 0xFFFFFFFF;

  std::string name;                  ///< as gpioinfo lists it; empty: given by chip and offset
  std::string chip;                  ///< name or label, as gpiodetect lists it
  std::uint32_t offset = kNoOffset;  ///< on the chip
  bool active_low = false;           ///< low voltage means on, up, pressed or open
  LineBias bias = LineBias::kAsIs;

  /// Whether the printer has this line.
  bool given() const { return !name.empty() || !chip.empty(); }
};

/// [display]: the panel's connector.
struct DisplaySettings {
  std::string card;                     ///< "/dev/dri/card0"; empty: the first one that has the connector
  std::string connector;                ///< "DSI-1", "HDMI-A-1", ...
  std::uint32_t refresh_hz = 0;         ///< of the mode; 0: any mode of the panel's size
  std::uint32_t plane = 0;              ///< as modetest lists it; 0: the primary plane
  std::uint32_t flip_timeout_ms = 500;  ///< a flip takes a frame, 17 ms at 60 Hz; this leaves a busy board room
};

/// [screen]: the small display for people.
struct ScreenSettings {
  std::uint32_t columns = 0, rows = 0;  ///< as people look at it, pixels; 0: the printer has none
  std::string card;                     ///< as [display]'s
  std::string connector;                ///< "HDMI-A-1", "SPI-1", ...
  std::uint32_t rotation_deg = 0;       ///< counter-clockwise, from the picture to what is sent
  std::uint32_t bits = 24;              ///< of a pixel: 16 or 24
  std::string touch;                    ///< "/dev/input/by-path/...-event"; empty: no touch

  bool given() const { return columns > 0; }
};

/// [lamp_sensor], [resin_sensor], [board_sensor]: a temperature sensor, given in one of three ways.
struct SensorSettings {
  std::string
      hwmon;  ///< the chip's name in /sys/class/hwmon/*/name, such as "lm75"; folder numbers change at each boot
  std::uint32_t channel = 1;  ///< of the chip: 1 is temp1_input
  std::string thermal_zone;   ///< the zone's type, such as "cpu-thermal"
  std::string file;           ///< holds thousandths of a degree, such as a 1-wire sensor's "temperature"

  bool given() const { return !hwmon.empty() || !thermal_zone.empty() || !file.empty(); }
};

/// [lamp_fan], [chamber_fan]: given in one of two ways, or absent.
struct FanSettings {
  std::string hwmon;             ///< the chip's name: pwm1 and, if it exists, fan1_input
  std::uint32_t channel = 1;     ///< from 1 on a hwmon chip, from 0 on a PWM chip
  std::string pwm_chip;          ///< "pwmchip0"
  std::uint32_t period_us = 40;  ///< of the PWM chip: 25 kHz, as Intel's specification of 4-wire fans has it

  bool given() const { return !hwmon.empty() || !pwm_chip.empty(); }
};

struct ThermalSettings {
  std::array<SensorSettings, kTemperatureSiteCount> sensors;  ///< by TemperatureSite
  std::array<FanSettings, kFanCount> fans;                    ///< by Fan
};

/// [stick]: where sticks are plugged in.
struct StickSettings {
  std::string port;  ///< "1-1.2": sticks elsewhere are ignored; empty: any port
};

/// [watchdog]: resets the board unless the keeper feeds it.
struct WatchdogSettings {
  std::string device;  ///< "/dev/watchdog0"; empty: the board has none
  /// The Raspberry Pi's goes up to 15 s. A shorter time leaves less to restart a daemon that died.
  std::uint32_t timeout_s = 10;
};

/// What the board file leaves out is empty.
struct Wiring {
  DisplaySettings display;
  ScreenSettings screen;
  LineSettings lamp;
  LineSettings cover;  ///< on: open
  LineSettings step;
  LineSettings direction;  ///< on: up
  LineSettings enable;     ///< not given: the driver always holds its motor
  LineSettings end_stop;   ///< on: pressed
  LineSettings start_button;
  LineSettings pause_button;
  LineSettings cancel_button;
  std::array<LineSettings, kPanelLightCount> lights;  ///< by PanelLight
  LineSettings buzzer;
  ThermalSettings thermals;
  StickSettings stick;
  WatchdogSettings watchdog;
};

/// What a line of the wiring is for.
struct LineRole {
  std::string_view table;  ///< of the board file
  const char* use;         ///< for messages
  bool required = false;   ///< no printer works without it
};

/// Calls visit(role, line) for each line of a wiring, given or not.
template <class SomeWiring, class Visit>
void for_each_line(SomeWiring& wiring, Visit&& visit) {
  visit(LineRole{"lamp_line", "the lamp", true}, wiring.lamp);
  visit(LineRole{"cover_line", "the cover"}, wiring.cover);
  visit(LineRole{"step_line", "the stage's step", true}, wiring.step);
  visit(LineRole{"direction_line", "the stage's direction", true}, wiring.direction);
  visit(LineRole{"enable_line", "the stage's enable"}, wiring.enable);
  visit(LineRole{"end_stop_line", "the end stop", true}, wiring.end_stop);
  visit(LineRole{"start_button", "the start button"}, wiring.start_button);
  visit(LineRole{"pause_button", "the pause button"}, wiring.pause_button);
  visit(LineRole{"cancel_button", "the cancel button"}, wiring.cancel_button);
  visit(LineRole{"ready_light", "the ready light"}, wiring.lights[0]);
  visit(LineRole{"printing_light", "the printing light"}, wiring.lights[1]);
  visit(LineRole{"attention_light", "the attention light"}, wiring.lights[2]);
  visit(LineRole{"fault_light", "the fault light"}, wiring.lights[3]);
  visit(LineRole{"buzzer", "the buzzer"}, wiring.buzzer);
}

}  // namespace plumbline::inline hal
