#pragma once
/// Lengths as people write them: "80mm", "8 cm", "3.15in".

#include <optional>
#include <string_view>

namespace plumbline {

inline constexpr const char* kLengthForm = "a length from 1 mm to 10 m, such as 80mm, 8cm or 3.15in";

/// @returns mm, kSmallestSizeMm to kLargestSizeMm; none if the text is anything but a number and mm, cm or in. A number alone
///          is mm
std::optional<double> parse_length(std::string_view text);

}  // namespace plumbline
