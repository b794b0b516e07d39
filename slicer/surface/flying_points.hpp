#pragma once
/// Finds flying points that would make the object larger than what is printed.

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline {

/// Marks flying points around the object as noise, so that its extents are those of its surface.
///
/// Takes the outermost surface point on each side of each axis and marks it if it is flying; then the next, until one is
/// surface. So it looks at a few points only, and a scan without flying points stays as it is. A point is flying if one of
/// these holds, among the points that are not noise:
///   - fewer than 32 points hang together with it in steps of 1.5 epsilon, or of the smaller support radius of two points
///     where that is larger: a lone point, a clump, a string,
///   - its eight nearest points lie in one direction, to eight degrees: it ends a string,
///   - it hangs above the sheet of its 32 nearest points: its mean height over their tangent planes is above 0.2 of their mean
///     distance, and above five standard deviations of the neighbours' own mean heights.
/// Points that would make a side longer by less than 0.115 epsilon, half the distance of two points, stay.
/// If more than a twentieth of the points are flying, the scan is not understood, and no point is marked.
///
/// @param cloud       in the order of `tree`, with classes; noise is not used
/// @param clustering  epsilon above 0
/// @param arena       a fifth more than four bytes a point from the top, released on return
/// @returns how many points were marked
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<std::uint32_t> mark_flying_points(Cloud& cloud, const KdTree3& tree,
                                                         const ClusteringResult& clustering, Arena& arena);

}  // namespace plumbline
