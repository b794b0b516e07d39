#include "hal/linux/gpio/line_registry.hpp"

#include <algorithm>

namespace plumbline::inline hal::inline linux_board {

Status LineRegistry::claim(const LinePlace& place, const std::string& use) {
  const auto taken =
      std::find_if(claims_.begin(), claims_.end(), [&](const Claim& claim) { return claim.place == place; });
  if (taken != claims_.end()) {
    return fail(ErrorCode::kBadSetting, "%s and %s use the same line, %s %u:\tcorrect the board file",
                taken->use.c_str(), use.c_str(), place.chip.c_str(), place.offset);
  }
  claims_.push_back({place, use});
  return {};
}

}  // namespace plumbline::inline hal::inline linux_board
