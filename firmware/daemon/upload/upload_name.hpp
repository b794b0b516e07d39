#pragma once

#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline {

/// Whether a name that somebody sent may become that of a file in the printer's store: a plain file name of at most 79 letters, digits,
/// spaces and `._-()+`, which begins with none of ` .-`, and ends like a scan, a mesh or a sliced archive.
/// @retval ErrorCode::kBadSetting     what is allowed
/// @retval ErrorCode::kUnknownFormat  it is sliced for another printer
[[nodiscard]] Status check_upload_name(std::string_view name);

}  // namespace plumbline
