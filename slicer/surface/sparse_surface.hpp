#pragma once
/// Parts of the surface that few views saw: too sparse for the density that the clustering asks for, but not noise.

#include <cstdint>
#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline::inline slicer {

/// Tests whether point i lies on a sparse sheet of points that face its way. Of the nearest of these, kSparsePoints (itself included) must
/// lie within kFarthest * epsilon by the metric of the clustering, and its mean pair_height() over them must be at most kMostHeight of their
/// mean distance. Beyond kSparseRadius * epsilon an outlier always finds some points for which that is true: there, all but kMayDiffer of
/// them must agree() with the point, each for itself.
///
/// @returns the radius of a disc as large as the point's share of that sheet, mm; nothing if it lies on none
std::optional<float> sparse_share(const Cloud& cloud, const KdTree3& tree, std::uint32_t i, float epsilon);

/// Repeats that test for all noise points. Many were noise because of a wrong normal, so call it after refine_normals()
/// has fitted new ones. Don't call it where most points are outliers: a few of them always happen to face the same way.
/// @param cloud   in the order of `tree`; sets class and radius[] of the points that are noise no more
/// @retval ErrorCode::kCancelled
[[nodiscard]] Status rescue_sparse_surface(Cloud& cloud, const KdTree3& tree, float epsilon,
                                           const StageProgress& progress = {});

/// Cuts supports wider than usual_support() to 1.25 times the median of their neighbours'. Where a few points happen to lie far apart, or the
/// points that face the same way belong to another part, the surface is not sparser.
/// @param cloud  in the order of `tree`, with classes and supports
/// @param arena  4 bytes a point from the top, released on return
[[nodiscard]] Status level_wide_supports(Cloud& cloud, const KdTree3& tree, float epsilon, Arena& arena);

}  // namespace plumbline::inline slicer
