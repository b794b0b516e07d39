#pragma once
/// What is plugged into a board, for somebody who writes its board file.

#include <string>

namespace plumbline::inline hal {

/// One device that a board file can name.
struct BoardPart {
  std::string kind;  ///< "connector", "line", "fan", "sensor", "stick port", "watchdog", "touch panel", "serial port"
  std::string
      answer;  ///< as `plumbline setup` takes it: "HDMI-A-1", "GPIO17", "1c20800.pinctrl 71", "hwmon lm75 1", "pwm pwmchip0 0"
  std::string detail;  ///< what else is known: modes, who holds the line
};

}  // namespace plumbline::inline hal
