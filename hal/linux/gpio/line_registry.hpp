#pragma once
/// Which line is used for what, so that no pin is used twice.

#include <string>
#include <vector>

#include "hal/linux/gpio/line_settings.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// Filled while the devices are opened; the kernel would notice a second use in this process only as "busy".
class LineRegistry {
 public:
  /// @param use  "the lamp": for the message to whoever wants the same line
  /// @retval ErrorCode::kBadSetting  another device has it: both are named
  [[nodiscard]] Status claim(const LinePlace& place, const std::string& use);

 private:
  struct Claim {
    LinePlace place;
    std::string use;
  };
  std::vector<Claim> claims_;
};

}  // namespace plumbline
