#pragma once
/// Parts of the surface that few views saw: too sparse for the density that the clustering asks for, but not noise.

#include <cstdint>
#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline {

/// Tests whether point i lies on a sparse sheet of points that face its way. Of the nearest of these, kSheetPoints (itself included) must
/// lie within kFarthest * epsilon by the metric of the clustering, and its mean height over them must be at most kMostHeight of
/// their mean distance:
///
///   height = 1/2 <n_i + n_j, p_i - p_j>
///
/// On a curved surface the two halves of a height cancel; for a point off the surface they add up. Beyond kSparseRadius * epsilon an
/// outlier always finds some points of which that is true: there, all but kMayDiffer of them must agree with the point, that is, face its
/// way within 60 degrees, and each lie no higher than that.
///
/// @returns the radius of a disc as large as the point's share of that sheet, mm; nothing if it lies on none
std::optional<float> sparse_share(const Cloud& cloud, const KdTree3& tree, std::uint32_t i, float epsilon);

/// Repeats that test for all noise points. Many were noise because of a wrong normal, so call it after refine_normals()
/// has fitted new ones. Don't call it where most points are outliers: a few of them always happen to face the same way.
/// @param cloud   in the order of `tree`; sets class and radius[] of the points that are noise no more
/// @retval ErrorCode::kCancelled
[[nodiscard]] Status rescue_sparse_surface(Cloud& cloud, const KdTree3& tree, float epsilon,
                                           const StageProgress& progress = {});

/// Cuts supports of more than usual_support() to 1.25 times the median of those of the nearest points that face the same way: where a few
/// points happen to be far apart, or face the way of those of another part, the surface is no sparser.
/// @param cloud  in the order of `tree`, with classes and supports
/// @param arena  4 bytes a point from the top, released on return
[[nodiscard]] Status level_wide_supports(Cloud& cloud, const KdTree3& tree, float epsilon, Arena& arena);

}  // namespace plumbline
