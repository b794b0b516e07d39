#pragma once
/// Finds flying points that would make the object larger than what is printed.

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline::inline slicer {

/// Marks flying points around the object as noise, so that its extents are those of its surface.
///
/// Takes the outermost surface point on each side of each axis and marks it if it is flying; then the next, until one is
/// surface. So it looks at a few points only, and a scan without flying points stays as it is. A point is flying if too few
/// others hang together with it (a lone point, a clump), if it ends a string, or if it hangs above the sheet of its nearest points.
/// Points that would make a side longer by less than half the distance of two points stay. If too many points are flying, the
/// scan is not understood, and none is marked.
///
/// @param cloud       in the order of `tree`, with classes; noise is not used
/// @param clustering  epsilon above 0
/// @param arena       a fifth more than four bytes a point from the top, released on return
/// @returns how many points were marked
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<std::uint32_t> mark_flying_points(Cloud& cloud, const KdTree3& tree,
                                                         const ClusteringResult& clustering, Arena& arena);

}  // namespace plumbline::inline slicer
