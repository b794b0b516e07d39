#pragma once
/// Tells the format of a scan by its first bytes.

#include "slicer/reader/stream/byte_input.hpp"

namespace plumbline {

/// Looks at as much of the start of the file as the window holds, and uses up no more of it than a UTF-8 byte order
/// mark.
///
/// PLY and PCD have a mark. OBJ is told by the keyword of the first line that is no comment, XYZ by its being a number;
/// where that line is neither, the name's ending decides.
/// @retval ErrorCode::kUnknownFormat  another known format, by name, or none
/// @retval ErrorCode::kUnsupported    text in UTF-16 or UTF-32
/// @retval ErrorCode::kNoPoints       an empty file
[[nodiscard]] Expected<ScanFormat> probe_format(ByteInput& input);

}  // namespace plumbline
