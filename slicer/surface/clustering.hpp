#pragma once
/// Density and orientation clustering (thesis III-2.b).

#include <array>
#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

/// Entering, exiting or neutral, by the angle between the normal and the manufacturing direction +z.
PointClass orientation_of(const PackedNormal& normal);

/// |<n, m>| below this is neutral: sin(5 degrees), the thesis' tolerance for the error of a scanned normal.
inline constexpr float kNeutralSine = 0.087155743F;

struct ClusteringSettings {
  std::uint32_t min_points = 30;  ///< minPts of the thesis
  double same_type_share = 0.75;  ///< a core point has more of its epsilon-neighbours of its own type than this share
  /// Noise of the thesis that has this many points, itself included, within thin_reach * epsilon by the same metric keeps
  /// its type: a part of the surface that few views saw. Not where most points are strays. A thin_reach of 0 leaves the
  /// noise as the thesis has it.
  std::uint32_t thin_points = 5;
  float thin_reach = 3;
  float least_support = 15;
  float most_support = 100;
  std::uint32_t epsilon_sample = 16384;  ///< points whose neighbours are searched; evenly spread over the order
};

/// epsilon: median over the points of the distance to the (2 minPts)-th nearest other point, mm.
///
///   epsilon = (d[floor(n/2)] + d[floor((n-1)/2)]) / 2, d ascending                       (thesis III-2.b)
///
/// A cloud larger than the sample is sampled at equal steps of its order, which is the tree's, so the sample is spread
/// evenly over the surface.
/// @returns mm; 0 when most points coincide
[[nodiscard]] Expected<float> density_epsilon(const Cloud& cloud, const KdTree3& tree,
                                              const ClusteringSettings& settings, Arena& arena);

struct ClusteringResult {
  float epsilon = 0;           ///< mm
  bool coherent = true;        ///< the median point's neighbours mostly face as it does; if not, most points are strays
  std::uint32_t clusters = 0;  ///< 0 if no labels were asked for
  std::array<std::uint32_t, kPointClassCount> points = {};  ///< by PointClass
  std::uint32_t core_points = 0;
  float noise = 0;           ///< mm; standard deviation of a point from the sheet of its neighbours, robustly
  float support_points = 0;  ///< points of a sheet that radius[] holds
};

/// Points that are no noise.
std::uint32_t points_of_surface(const ClusteringResult& clustering);

/// Whether at most a thousandth of what is no noise is of this class. With hardly any entering points a scan is a height
/// field; with hardly any exiting ones it lies on its face.
bool hardly_any(const ClusteringResult& clustering, PointClass point_class);

inline constexpr std::uint32_t kNoCluster = 0xFFFFFFFFU;

/// Sorts every point into entering, exiting, neutral or noise, and sets its radius.
///
/// Distance of two points: |p_i - p_j| / <n_i, n_j>, infinite where the inner product is not positive. A point is core if
/// more than minPts points, itself included, lie within epsilon and more than 75 % of them are of its type. Core points of
/// one type within epsilon of one another form a cluster; any other point joins the cluster of the core point of its type
/// that is nearest, within epsilon, ties by index. What joined no cluster and has fewer than minPts neighbours is noise;
/// what has enough neighbours but of mixed type keeps its type without a cluster, as the thesis' wording has it: a noisy
/// vertical wall mixes all three types and is no noise.
///
/// radius[i] is set to the radius of a disc that holds about `support_points` points at the surface density seen around
/// i: least_support where the scan is clean, up to most_support where its noise has to be averaged out.
///
/// @param cloud    in the order of `tree`; normal[].point_class and radius[] are set
/// @param cluster  cloud.size labels, out: the lowest index of a core point of the cluster, kNoCluster for none. Empty
///                 where nobody asks for them: what is noise depends on the core points, not on which of them join
/// @param progress  heard of in all threads' work, from the caller's thread
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<ClusteringResult> cluster(Cloud& cloud, const KdTree3& tree, float epsilon,
                                                 const ClusteringSettings& settings, std::span<std::uint32_t> cluster,
                                                 Arena& arena, const StageProgress& progress = {});

}  // namespace plumbline
