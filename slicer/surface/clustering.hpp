#pragma once
/// Density and orientation clustering (thesis III-2.b).

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/surface_class.hpp"

namespace plumbline {

struct ClusteringSettings {
  std::uint32_t min_points = 30;  ///< minPts of the thesis
  double same_type_share = 0.75;  ///< a core point has more than this share of neighbours of its own type (thesis)
  // Beyond the thesis: a noise point keeps its type if it lies on a sheet of `sparse_points` points, itself included,
  // within `sparse_radius` by the same metric. Such a sheet is a part of the surface that few views saw. The rule does
  // not apply where most points are outliers.
  std::uint32_t sparse_points = 5;  ///< larger values lose the walls of narrow bores: slicer/EXPERIMENTS.md
  float sparse_radius = 3;          ///< epsilons; 0 keeps the thesis' noise
  float min_support = 15;           ///< points of a support on a clean scan; more lose detail (slicer/EXPERIMENTS.md)
  float max_support = 100;          ///< points of a support on a noisy scan; more lose detail and take time
  std::uint32_t epsilon_sample = 16384;  ///< points measured for epsilon: within 1 % of the whole cloud's
};

/// epsilon: the median over the points of the distance to the (2 minPts)-th nearest other point, mm.
///
///   epsilon = (d[floor(n/2)] + d[floor((n-1)/2)]) / 2, d ascending                       (thesis III-2.b)
///
/// A larger cloud is sampled at equal steps of its order. This is the tree's, so the sample is spread evenly over the
/// surface.
/// @returns mm; 0 when most points coincide
[[nodiscard]] Expected<float> density_epsilon(const Cloud& cloud, const KdTree3& tree,
                                              const ClusteringSettings& settings, Arena& arena);

struct ClusteringCounts {
  bool coherent = true;        ///< false if most points are outliers: the median point's neighbours face other ways
  std::uint32_t clusters = 0;  ///< 0 if no labels were asked for
  ClassCounts points;          ///< by class
  std::uint32_t core_points = 0;
};
struct ClusteringResult : ClusteringCounts {
  float epsilon = 0;  ///< in the unit of the cloud
  float noise =
      0;  ///< standard deviation of points off the sheet of their neighbours, from the median; unit of the cloud
};

inline constexpr std::uint32_t kNoCluster = 0xFFFFFFFFU;

/// Sorts every point into entering, exiting, neutral or noise, and sets its support radius.
///
/// Distance of two points: |p_i - p_j| / <n_i, n_j>, infinite if the inner product is not positive. A point is core if
/// more than minPts points, itself included, lie within epsilon and more than 75 % of them have its type. Core points
/// of one type within epsilon of each other form a cluster. Any other point joins the cluster of the nearest core point
/// of its type within epsilon; ties go to the lower index. A point that joins no cluster is noise if it has fewer than
/// minPts neighbours. With enough neighbours of mixed type it keeps its type without a cluster, as the thesis' wording
/// has it: a noisy vertical wall mixes all three types and is not noise.
///
/// Cloud::radius is set for supports that hold Cloud::support_points points at the density of the surface
/// around i: min_support on a clean scan, up to max_support where noise must be averaged out.
///
/// @param cloud    in the order of `tree`; normal[].point_class and radius[] are set
/// @param labels   cloud.size labels, output: the lowest index of a core point of the cluster, kNoCluster for none.
///                 Empty if not needed: whether a point is noise depends on the core points, not on how they join
/// @param progress  called from the caller's thread only
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<ClusteringResult> cluster(Cloud& cloud, const KdTree3& tree, float epsilon,
                                                 const ClusteringSettings& settings, std::span<std::uint32_t> labels,
                                                 Arena& arena, const StageProgress& progress = {});

}  // namespace plumbline
