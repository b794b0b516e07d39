#pragma once
/// The points of a PCD file with DATA binary_compressed.

#include "slicer/core/arena.hpp"
#include "slicer/reader/formats/pcd_header.hpp"
#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline {

/// Bytes that read_pcd_compressed() takes of its memory, saturated; 0 where the file is not compressed.
std::uint64_t compressed_columns_bytes(const PcdHeader& header);

/// See read_pcd() for what it needs and refuses.
[[nodiscard]] Status read_pcd_compressed(ByteInput& input, const PcdHeader& header, PointBatch& batch, Arena& memory);

}  // namespace plumbline
