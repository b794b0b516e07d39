#pragma once
/// Finds outliers by their density, before anything is fitted to points.

#include <cstddef>
#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline::inline slicer {

/// Arena bytes that drop_outliers() takes.
std::size_t outliers_bytes(std::uint32_t points);

/// Removes outliers: points that are sparse and lie on no sheet.
///
/// A point is sparse if its eighth nearest is more than twice as far as the median point's. It lies on a sheet if its 16 nearest are flat
/// and it lies on their plane, or if it lies within reach of such a neighbour and on that one's plane, as beside an edge; or if its 16
/// nearest sparse ones are, as on the side of a thin wall that few views saw. So outliers around and inside the object go, whose neighbours
/// fill space, and a part of the surface that few views saw stays. So does a point whose own normal agrees with four of the five nearest
/// that face its way. Up to 1 % of outliers are left to the clustering.
///
/// @param cloud  in the order of `tree`, which the other points keep; overwrites radius[]
/// @param arena  outliers_bytes() from the top, released on return
/// @returns how many were removed: then the tree is that of another cloud
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<std::uint32_t> drop_outliers(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                    const StageProgress& progress = {});

}  // namespace plumbline::inline slicer
