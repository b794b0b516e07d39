#pragma once
/// Pieces of the scan that are not the object: a bit of the wall behind it, of the turntable, of a hand that held it.

#include <cstddef>
#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline {

struct StrayPieces {
  std::uint32_t pieces = 0;
  std::uint32_t points = 0;
  float share = 0;  ///< of the surface of all pieces, 0 to 1
};

/// Bytes of arena that mark_stray_pieces() takes.
std::size_t stray_pieces_bytes(std::uint32_t points);

/// Marks the points of stray pieces as noise.
///
/// The points are sorted into cells one and a half epsilon wide; a piece is what occupied cells join at sides, edges and corners, and
/// its size the area of its points. A piece is a stray when all of this holds:
///   - it has less than a fiftieth of the largest piece's area,
///   - the winding number of all other points is nearly 0 along it, or nearly 1: it hangs in the air, or where no scanner
///     sees. What is seen through a mouth or at the bottom of a hole lies where that number says neither;
///   - all strays together have less than a twentieth of the area of what stays.
/// So two legs are an object, as are a hundred beads round a ball; a patch of a wall behind is not.
///
/// @param cloud       scan units, radius[] set by the clustering, some of it no noise; what is noise is not looked at
/// @param clustering  epsilon, in scan units, above 0
/// @param arena       stray_pieces_bytes() from the top, given back
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<StrayPieces> mark_stray_pieces(Cloud& cloud, const ClusteringResult& clustering, Arena& arena);

}  // namespace plumbline
