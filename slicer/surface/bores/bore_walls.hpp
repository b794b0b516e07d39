#pragma once
/// Extends the walls of bores where no view has seen them.

#include <cstddef>
#include <cstdint>

#include "slicer/surface/clustering.hpp"

namespace plumbline {

struct BoreWalls {
  std::uint32_t points = 0;  ///< added to the cloud
  float area = 0;            ///< of the added walls, squared units of the cloud
};

/// Arena bytes that continue_bore_walls() takes for a cloud of `points`.
std::size_t bore_walls_bytes(std::uint32_t points);

/// Extends the walls of deep bores between the parts that were seen from their two ends.
///
/// A scanner sees some way into a deep bore from either mouth. To the winding number the part between is solid, since
/// two caps are less surface than a tube. But if walls run in line from both ends and nothing was seen between them,
/// they belong to one bore: two blind holes that meet so exactly are rare, and a bottom is seen more often than a wall.
///
/// An end is a point on a sparse part of the surface with a wall opposite that faces it. The distance of the two is the width.
/// Round bores come first (continue_round_bores()). For other bores two ends belong together if
///   - their normals agree, their widths are alike, and the line between them runs along the surface,
///   - no point lies on the middle half of the line, so it was not seen; and none in front of it in the middle of the bore,
///   - there is wall in all of eight directions around the bore at either end. Two surfaces that merely face each other
///     are not a bore.
/// Points are added along the line, except where the wall was seen. Nothing is done where much of the surface is sparse: there
/// epsilon does not stand for a density.
///
/// @param cloud       in the order of `tree`, classes and radius[] set. New points are appended, up to its capacity,
///                    and counted in Cloud::continued. Points of round bores get the normals of their walls
/// @param clustering  epsilon above 0
/// @param arena       bore_walls_bytes() from the top, released on return
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<BoreWalls> continue_bore_walls(Cloud& cloud, const KdTree3& tree,
                                                      const ClusteringResult& clustering, Arena& arena,
                                                      const StageProgress& progress = {});

}  // namespace plumbline
