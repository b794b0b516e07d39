#pragma once
/// Several exposures in one print, to find the one that a resin needs.

#include <array>
#include <cstdint>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline settings {

/// The object is divided along x in as many strips of equal width as there are exposures.
struct ExposureTest {
  static constexpr std::uint32_t kMostStrips = 8;

  std::uint32_t strips = 0;                   ///< 2 to kMostStrips; 0: no test
  std::array<double, kMostStrips> seconds{};  ///< of normal layers, ascending

  double longest() const { return seconds[strips - 1]; }
};

/// "1.6s,2s,2.4s", the s may be left out.
/// @retval ErrorCode::kBadSetting  what was found and what is allowed: too few or too many, out of the range of exposure_time, not ascending
[[nodiscard]] Expected<ExposureTest> parse_exposure_test(std::string_view text);

}  // namespace plumbline::firmware::inline settings
