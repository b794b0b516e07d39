#pragma once
/// One reader for each format. Each starts at the first byte of the file, or after its byte order mark, calls
/// PointBatch::begin() once and adds every point. The caller flushes the last batch.

#include "slicer/core/arena.hpp"
#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline::inline slicer {

/// Polygon file format: ascii, and binary in both byte orders. Gaussian splats are recognised by their properties; the input is
/// rewound for them (SplatFilter).
[[nodiscard]] Status read_ply(ByteInput& input, PointBatch& batch, Arena& memory);

/// Rows of numbers: .xyz, .txt, .asc, .pts.
[[nodiscard]] Status read_xyz(ByteInput& input, PointBatch& batch, Arena& memory);

/// Point Cloud Library, versions 0.5 to 0.7: ascii, binary, binary compressed.
///
/// @param columns  holds the columns of binary_compressed, which come one after another: all wanted ones but the last are
///                 kept until the last comes. 8 bytes a point for x, y, z of 4 bytes each, 20 with normals. May be `memory`
/// @retval ErrorCode::kUnsupported  the columns of a compressed file do not fit in the rest of `columns`
[[nodiscard]] Status read_pcd(ByteInput& input, PointBatch& batch, Arena& memory, Arena& columns);

/// The vertices of a Wavefront OBJ; its normals only where `vn` and `v` lines alternate.
[[nodiscard]] Status read_obj(ByteInput& input, PointBatch& batch, Arena& memory);

/// ASPRS LAS 1.0 to 1.4, point formats 0 to 10. Points that are marked as withheld or as noise are left out.
/// @retval ErrorCode::kUnsupported  LAZ, which is compressed
[[nodiscard]] Status read_las(ByteInput& input, PointBatch& batch);

/// Leica PTX: one or more scans, each a grid of points with the transform from the scanner to the common frame. Points at
/// 0 0 0 are rays that returned nothing and are left out.
[[nodiscard]] Status read_ptx(ByteInput& input, PointBatch& batch);

/// ASTM E57, in mm: the standard's unit is the metre. All scans of the file in their common frame, with their normals if they
/// have the extension for them. Points that are marked as invalid are left out; images are ignored. Rewinds the input, because
/// what says where the points are comes after them.
/// @param memory  all that is left of it is used
[[nodiscard]] Status read_e57(ByteInput& input, PointBatch& batch, Arena& memory);

/// SPZ versions 1 to 3: Gaussian splats, compressed by gzip.
/// @param columns  holds 13 bytes a point, as for read_pcd(), until the rotations come
/// @retval ErrorCode::kUnknownFormat  gzip, but not of an SPZ
/// @retval ErrorCode::kUnsupported    another version, or the columns don't fit
[[nodiscard]] Status read_spz(ByteInput& input, PointBatch& batch, Arena& memory, Arena& columns);

}  // namespace plumbline::inline slicer
