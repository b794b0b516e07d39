#pragma once
/// Values of print settings as people write them.

#include <optional>
#include <string_view>

#include "firmware/settings/print_fields.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline settings {

/// @returns none: an empty text, which takes the value back
/// @retval ErrorCode::kBadSetting  the key, what was found, what is allowed
[[nodiscard]] Expected<std::optional<double>> parse_print_value(const PrintField& field, std::string_view text);

/// Sets what "exposure_time=3" says.
/// @retval ErrorCode::kBadSetting  it has no '=', no person can set that key, or as above
[[nodiscard]] Status parse_assignment(std::string_view text, PrintValues& values);

}  // namespace plumbline::firmware::inline settings
