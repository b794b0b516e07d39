#pragma once
/// Where a line of a GPIO chip is and what its voltages mean: as the board file has it.

#include <cstdint>
#include <string>

namespace plumbline {

enum class LineBias : std::uint8_t {
  kAsIs,      ///< as the board's firmware or device tree left it
  kDisabled,  ///< floating: something on the board pulls it
  kPullUp,
  kPullDown,
};

/// Named by the board (`gpioinfo` lists names), or by chip and offset where it is not.
struct LineSettings {
  std::string name;          ///< empty: by chip and offset
  std::string chip;          ///< "gpiochip0", or the chip's label
  std::uint32_t offset = 0;  ///< on the chip
  bool active_low = false;   ///< low voltage is "on", "pressed", "open"
  LineBias bias = LineBias::kAsIs;

  /// The board has this line.
  bool given() const { return !name.empty() || !chip.empty(); }
};

/// A line that was found.
struct LinePlace {
  std::string chip;  ///< "gpiochip0"
  std::uint32_t offset = 0;

  bool operator==(const LinePlace&) const = default;
};

}  // namespace plumbline
