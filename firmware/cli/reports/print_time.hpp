#pragma once
/// Estimates how long a print will take, for reports before it starts.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "firmware/settings/board_file.hpp"

namespace plumbline::firmware {

struct PrintTime {
  std::chrono::nanoseconds time{};
  std::string profile;  ///< that it was estimated with

  /// "about 4 h 10 min with the profile standard", rounded to ten minutes above an hour, to one minute below.
  std::string text() const;
};

/// The time of a whole print with the profile of the board file.
/// @returns nothing if the board file describes no machine, or if its profile is missing or can't print these layers
std::optional<PrintTime> estimate_print_time(const BoardFile& board, std::uint32_t layers, double layer_height_mm);

}  // namespace plumbline::firmware
