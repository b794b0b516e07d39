#pragma once
/// Walls of bores, continued where no view has seen them.

#include <cstddef>
#include <cstdint>

#include "slicer/surface/clustering.hpp"

namespace plumbline {

struct BoreWalls {
  std::uint32_t points = 0;  ///< added to the cloud
  float area = 0;            ///< of the walls that they stand for, squared units of the cloud
};

/// Bytes of arena that continue_bore_walls() takes for a cloud of `points`.
std::size_t bore_walls_bytes(std::uint32_t points);

/// Continues walls between what was seen of them from the two ends of a bore.
///
/// Into a deep bore a scanner sees some way from either mouth. What lies between is solid to the winding number, since two
/// caps are less surface than a tube. But walls that go on in line from both ends, with nothing seen between them, are
/// those of one bore: two blind holes that face each other so exactly are rare, and a bottom is seen more often than a
/// wall.
///
/// An end is a point of a sparse part of the surface (under a fifth of the density that epsilon tells) with another part
/// opposite that faces it, at most eight epsilon away: the width. Round bores come first (continue_round_bores()). For others
/// two ends belong together if
///   - their normals agree to 60 degrees, and the line between them runs along the surface, to one part in five,
///   - they are at least two epsilon apart, and at most six widths; their widths differ by half at most,
///   - within epsilon of the middle half of the line, and within a third of the width of the line half a width before the
///     wall, there is no point: it was not seen, and nothing stands in the bore,
///   - there are walls all round the bore at either end, looked for in eight directions: two things that face each other
///     are no bore.
/// The line between them gets a point each half epsilon, except where the wall has been seen. Nothing is done where more
/// than a sixteenth of the points are sparse: epsilon tells no density there. Of more than 4096 ends the first are taken.
///
/// @param cloud       in the order of `tree`, classes and radius[] set; it grows, at most to its capacity. The new points
///                    are the last, counted in Cloud::continued
///                    Points of round bores get the normals of their walls
/// @param clustering  epsilon above 0; its points by class follow
/// @param arena       bore_walls_bytes() from the top, given back
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<BoreWalls> continue_bore_walls(Cloud& cloud, const KdTree3& tree, ClusteringResult& clustering,
                                                      Arena& arena, const StageProgress& progress = {});

}  // namespace plumbline
