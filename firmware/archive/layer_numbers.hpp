#pragma once
/// Which files of an archive or a folder are layers, and whether one is missing.

#include <cstdint>
#include <optional>
#include <string_view>

#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"

namespace plumbline::firmware::inline archive {

/// The name of an archive's entry without the folders before it. Some programs for Windows write backslashes between them.
std::string_view file_of_entry(std::string_view name);

/// Whether a PNG file is the slicer's picture of the print.
/// @param name  with the folders before it
bool is_thumbnail(std::string_view name);

/// @returns the last number in the name of a PNG file; none: it has none below 2^64, or it is another file, a hidden one, a thumbnail or a
///          preview
std::optional<std::uint64_t> number_of_layer(std::string_view name);

/// @param number_of  of each layer, in growing order
/// @param where      the archive or folder, for the message
/// @retval ErrorCode::kMalformed  a number is missing
[[nodiscard]] Status check_none_missing(std::size_t layers, FunctionRef<std::uint64_t(std::size_t)> number_of,
                                        const char* where);

}  // namespace plumbline::firmware::inline archive
