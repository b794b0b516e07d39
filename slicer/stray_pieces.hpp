#pragma once
/// Pieces of the scan that are not the object: a bit of the wall behind it, of the turntable, of a hand that held it.

#include <cstddef>
#include <cstdint>

#include "slicer/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

struct StrayPieces {
  std::uint32_t pieces = 0;
  std::uint32_t points = 0;
  float share = 0;  ///< of the surface of all pieces, 0 to 1
};

/// Bytes of arena that drop_stray_pieces() takes.
std::size_t stray_pieces_bytes();

/// Drops stray pieces from the cloud, and keeps the order of the rest.
///
/// The points are sorted into cells of a 32nd of the longest side, but at least four epsilon; a piece is what occupied cells
/// join at sides, edges and corners, and its size the area of its points. A piece is a stray when all of this holds:
///   - it has less than a fiftieth of the largest piece's area,
///   - no cell of it lies within one cell of the box round all pieces that have more,
///   - all strays together have less than a twentieth of the area of what stays.
/// So two legs are an object, as are a hundred beads round a ball and what is seen through a mouth; a patch of a wall far
/// behind is not. What is left is looked at again, since without a far piece cells are finer: eight times at most.
///
/// @param cloud    scan units, radius[] set, without noise
/// @param epsilon  scan units, above 0
/// @param arena    stray_pieces_bytes() from the top, given back
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<StrayPieces> drop_stray_pieces(Cloud& cloud, float epsilon, Arena& arena);

}  // namespace plumbline
