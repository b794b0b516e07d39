#pragma once
/// Detects the format of a scan from its first bytes.

#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::inline slicer {

inline constexpr std::string_view kE57Signature = "ASTM-E57";
inline constexpr std::string_view kZipSignature = "PK\x03\x04";

/// Looks at as much of the file's start as the window holds. Consumes only a UTF-8 byte order mark.
///
/// PLY, PCD, LAS and E57 have a signature. For the others, the first line that is no comment decides: an OBJ keyword makes it OBJ, a
/// number XYZ, two lines of one whole number PTX. Otherwise the name's ending decides.
/// @retval ErrorCode::kUnknownFormat  the message names the format if it is a known one
/// @retval ErrorCode::kUnsupported    text in UTF-16 or UTF-32
/// @retval ErrorCode::kNoPoints       an empty file
[[nodiscard]] Expected<ScanFormat> probe_format(ByteInput& input);

/// "PLY", "XYZ", "PCD", and so on: in lower case also the ending of such a file.
const char* to_string(ScanFormat format);

}  // namespace plumbline::inline slicer
