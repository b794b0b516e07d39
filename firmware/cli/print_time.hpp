#pragma once
/// How long a print would take, for reports of what is not printed yet.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "firmware/settings/board_file.hpp"

namespace plumbline {

struct PrintTime {
  std::chrono::nanoseconds time{};
  std::string profile;  ///< whose settings it takes

  /// "about 4 h 10 min with the profile standard", to ten minutes above an hour and to one below.
  std::string text() const;
};

/// The time of a whole print with the profile of the board file.
/// @returns none where the board file describes no machine, or where its profile is missing or can't print these layers
std::optional<PrintTime> estimate_print_time(const BoardFile& board, std::uint32_t layers, double layer_height_mm);

}  // namespace plumbline
