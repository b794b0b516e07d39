#pragma once
/// Finds pieces of the scan that are not the object: parts of the wall behind it, of the turntable, of a hand that held
/// it.

#include <cstddef>
#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline::inline slicer {

/// Points up to so many epsilons apart hang together: that joins the sparse parts of one surface, but not two separate things.
inline constexpr float kTogetherEpsilons = 1.5F;
/// Least points of a stray piece. Fewer are flying points.
inline constexpr std::uint32_t kFewestOfPiece = 32;

struct StrayPieces {
  std::uint32_t pieces = 0;
  std::uint32_t points = 0;
  float share = 0;  ///< of the area of all pieces, 0 to 1
};

/// Arena bytes that mark_stray_pieces() takes.
std::size_t stray_pieces_bytes(std::uint32_t points);

/// Marks the points of stray pieces as noise.
///
/// The points are sorted into cells (CellPieces); the size of a piece is the area of its points. A piece is a stray piece if
///   - it is small beside the largest piece,
///   - the winding number of all other points along it is nearly 0 or nearly 1: it is in the air, or inside where no
///     scanner sees. On surface seen through a mouth, or at the bottom of a hole, the number is neither,
///   - all stray pieces together are small beside what stays.
/// So two legs are an object, and a hundred beads around a ball are; a part of the wall behind is not.
///
/// @param cloud       scan units; radius[] set by the clustering. Noise is not used, and there must be other points
/// @param clustering  epsilon in scan units, above 0
/// @param arena       stray_pieces_bytes() from the top, released on return
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<StrayPieces> mark_stray_pieces(Cloud& cloud, const ClusteringResult& clustering, Arena& arena);

}  // namespace plumbline::inline slicer
