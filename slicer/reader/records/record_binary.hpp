#pragma once
/// Reads records of a binary file.

#include <bit>
#include <cstdint>

#include "slicer/reader/records/record.hpp"
#include "slicer/reader/stream/byte_input.hpp"

namespace plumbline::inline slicer {

/// Reads `count` records as points.
/// @retval ErrorCode::kTruncated  the file ends before the last of them
/// @retval ErrorCode::kMalformed  a list has a negative number of items
[[nodiscard]] Status read_binary_points(ByteInput& input, const RecordLayout& layout, std::uint64_t count,
                                        std::endian order, PointBatch& batch);

/// Skips `count` records. Errors as above.
[[nodiscard]] Status skip_binary_records(ByteInput& input, const RecordLayout& layout, std::uint64_t count,
                                         std::endian order);

}  // namespace plumbline::inline slicer
