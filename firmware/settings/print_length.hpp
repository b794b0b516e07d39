#pragma once
/// Lengths and heights as people write them: "80mm", "8 cm", "3.15in".

#include <optional>
#include <string_view>

#include "slicer/placement/floor_choice.hpp"

namespace plumbline::firmware::inline settings {

inline constexpr const char* kLengthForm = "a length from 1 mm to 10 m, such as 80mm, 8cm or 3.15in";

/// @returns mm, kSmallestSizeMm to kLargestSizeMm; none if the text is anything but a number and mm, cm or in. A number alone
///          is mm
std::optional<double> parse_length(std::string_view text);

inline constexpr const char* kFloorForm = "auto, keep, or a height of the scan in its own unit, such as -3.5";

/// "auto", "keep", or a number: everything below that height is cut off.
std::optional<FloorChoice> parse_floor(std::string_view text);

}  // namespace plumbline::firmware::inline settings
