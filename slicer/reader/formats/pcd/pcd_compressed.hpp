#pragma once
/// Reads the points of a PCD file with DATA binary_compressed.

#include "slicer/core/arena.hpp"
#include "slicer/reader/formats/pcd/pcd_header.hpp"
#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline::inline slicer {

/// Bytes that read_pcd_compressed() takes from `memory`, saturated; 0 if the file is not compressed.
std::uint64_t compressed_columns_bytes(const PcdHeader& header);

/// Reads the points; see read_pcd() for memory and errors.
[[nodiscard]] Status read_pcd_compressed(ByteInput& input, const PcdHeader& header, PointBatch& batch, Arena& memory);

}  // namespace plumbline::inline slicer
