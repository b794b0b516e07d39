#pragma once
/// Parts of the surface that few views saw: too thin for the density of the clustering, and no noise.

#include <cstdint>
#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline {

/// Whether point i lies on a sheet of points that face its way. It does if settings.thin_points of its 16 nearest, itself
/// included, lie within settings.thin_reach * epsilon by the metric of the clustering, and if its mean height over them is
/// at most a fifth of their mean distance:
///
///   height = 1/2 <n_i + n_j, p_i - p_j>
///
/// The two halves of a height are alike and opposite where the surface is curved, and add up where the point lies off it.
///
/// @returns the radius of a disc as large as its share of that sheet, mm; none where it is on none
std::optional<float> thin_surface_radius(const Cloud& cloud, const KdTree3& tree, std::uint32_t i, float epsilon,
                                         const ClusteringSettings& settings);

/// Asks that of all noise once more. Noise was often thrown out for its normal: call it when refine_normals() has fitted it
/// another, and not where most points are strays, of which a few always happen to face the same way.
/// @param cloud   in the order of `tree`; the classes and radius[] of what is no noise any more are set
/// @param result  of cluster(), its counts are brought up to date
/// @retval ErrorCode::kCancelled
[[nodiscard]] Status rescue_thin_surface(Cloud& cloud, const KdTree3& tree, const ClusteringSettings& settings,
                                         ClusteringResult& result, const StageProgress& progress = {});

}  // namespace plumbline
