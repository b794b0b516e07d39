#pragma once

#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Whether a name that somebody sent may become that of a file in the printer's store: a plain file name of at most 79 letters, digits,
/// spaces and `._-()+`, which begins with none of ` .-`, and ends like a scan, a mesh or a sliced archive.
/// @retval ErrorCode::kBadSetting     what is allowed
/// @retval ErrorCode::kUnknownFormat  it is sliced for another printer
[[nodiscard]] Status check_upload_name(std::string_view name);

/// The name of any file as it may be in the printer's store: other characters become _, and a long one is cut before its ending. What
/// kind of file it is does not matter here.
FixedText<80> upload_name_of(std::string_view file_name);

}  // namespace plumbline::firmware
