#pragma once
/// Where a line was found.

#include <cstdint>
#include <string>

namespace plumbline::inline hal::inline linux_board {

struct LinePlace {
  std::string chip;  ///< "gpiochip0"
  std::uint32_t offset = 0;

  bool operator==(const LinePlace&) const = default;
};

}  // namespace plumbline::inline hal::inline linux_board
