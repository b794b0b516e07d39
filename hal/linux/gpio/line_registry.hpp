#pragma once
/// Refuses to use a line twice.

#include <string>
#include <vector>

#include "hal/linux/gpio/line_place.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Filled while the devices are opened. The kernel would report a second use only as "busy".
class LineRegistry {
 public:
  /// @param use  "the lamp", for the message
  /// @retval ErrorCode::kBadSetting  another device has it; the message names both
  [[nodiscard]] Status claim(const LinePlace& place, const std::string& use);

 private:
  struct Claim {
    LinePlace place;
    std::string use;
  };
  std::vector<Claim> claims_;
};

}  // namespace plumbline::inline hal::inline linux_board
