#pragma once
/// What follows the last record that a header declares. More records would be a part of the object that nobody prints.

#include <cstdint>
#include <limits>

#include "slicer/reader/stream/line_input.hpp"

namespace plumbline::inline slicer {

/// Takes what follows the last record: nothing, less than a record, or zeros that fill a block of a medium.
/// @param what   of the records, in the plural
/// @param count  that the header declares
/// @param least  bytes of the smallest record
/// @param limit  bytes from here; behind them is something else
/// @retval ErrorCode::kMalformed  there may be more records
[[nodiscard]] Status check_end(ByteInput& input, const char* what, std::uint64_t count, std::uint64_t least,
                               std::uint64_t limit = std::numeric_limits<std::uint64_t>::max());

/// The same of a text, where a line that begins with a number is a record.
[[nodiscard]] Status check_text_end(LineInput& lines, const char* what, std::uint64_t count);

}  // namespace plumbline::inline slicer
