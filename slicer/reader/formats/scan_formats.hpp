#pragma once
/// One reader a format. Each takes the input at the first byte of the file, or behind its byte order mark, begins the
/// batch once and adds every point; the last batch is flushed by the caller.

#include "slicer/core/arena.hpp"
#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline {

/// Polygon file format: ascii, binary of both byte orders.
[[nodiscard]] Status read_ply(ByteInput& input, PointBatch& batch, Arena& memory);

/// Rows of numbers: .xyz, .txt, .asc, .pts.
[[nodiscard]] Status read_xyz(ByteInput& input, PointBatch& batch, Arena& memory);

/// Point Cloud Library, versions 0.5 to 0.7: ascii, binary, binary compressed.
///
/// @param columns  binary_compressed holds one column behind the other, so all the wanted columns but the last one must
///                 be kept until that one comes: 8 bytes a point for x, y, z of 4 bytes each, 20 with normals. May be
///                 `memory`
/// @retval ErrorCode::kUnsupported  a compressed file whose columns do not fit in what is left of `columns`
[[nodiscard]] Status read_pcd(ByteInput& input, PointBatch& batch, Arena& memory, Arena& columns);

/// The vertices of a Wavefront OBJ; its normals where `vn` lines go with `v` lines one by one.
[[nodiscard]] Status read_obj(ByteInput& input, PointBatch& batch, Arena& memory);

}  // namespace plumbline
