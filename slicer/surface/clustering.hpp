#pragma once
/// Density and orientation clustering (thesis III-2.b).

#include <cstddef>
#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/surface_class.hpp"

namespace plumbline::inline slicer {

/// Points that tell a median over the scan: within 1 % of the whole cloud's.
inline constexpr std::uint32_t kMedianSample = 16384;

/// minPts of the thesis.
inline constexpr std::uint32_t kMinPts = 30;
/// A core point has more than this share of neighbours of its own type (thesis).
inline constexpr double kSameTypeShare = 0.75;
/// Points of a support on a clean scan. More lose detail: slicer/EXPERIMENTS.md.
inline constexpr float kCleanSupport = 8;
/// Points of a support on a noisy scan. More lose detail and take time.
inline constexpr float kNoisySupport = 100;

/// Epsilons. Beyond the thesis, a noise point keeps its type if it lies on a sparse sheet: sparse_share(). Within that distance the sheet
/// is tested as a whole, beyond it point by point. Such a sheet is a part of the surface that few views saw. The rule does not apply where
/// most points are outliers.
inline constexpr float kSparseRadius = 3;
enum class SparseSurface : std::uint8_t { kKept, kNoise };  ///< kNoise: as in the thesis

/// epsilon: the median over the points of the distance to the (2 minPts)-th nearest other point, mm.
///
///   epsilon = (d[floor(n/2)] + d[floor((n-1)/2)]) / 2, d ascending                       (thesis III-2.b)
///
/// A cloud of more than `most_samples` points is sampled at equal steps of its order. This is the tree's, so the sample is
/// spread evenly over the surface.
/// @returns mm; 0 when most points coincide
[[nodiscard]] Expected<float> density_epsilon(const Cloud& cloud, const KdTree3& tree, Arena& arena,
                                              std::uint32_t most_samples = kMedianSample);

struct ClusteringCounts {
  bool coherent = true;  ///< false if most points are outliers: the median point's neighbours face other ways
  ClassCounts points;    ///< by class
  std::uint32_t core_points = 0;
};
struct ClusteringResult : ClusteringCounts {
  float epsilon = 0;  ///< in the unit of the cloud
  float noise =
      0;  ///< standard deviation of points off the sheet of their neighbours, from the median; unit of the cloud
};

/// Radius of a support on a sheet of the median density and somewhat wider, in the unit of epsilon. Only where the scan is sparse, and only
/// as far as kCleanSupport points need it, rays look farther.
float usual_support(float epsilon, float support_points);
/// Supports that may be wider on rays, or what is usual grows until no more are.
inline std::uint32_t most_wide_supports(std::uint32_t points) { return points / 32; }

/// Arena bytes that cluster() takes.
std::size_t clustering_bytes(std::uint32_t points);

/// Sorts every point into entering, exiting, neutral or noise, and sets its support radius.
///
/// Distance of two points: |p_i - p_j| / <n_i, n_j>, infinite if the inner product is not positive. A point is core if
/// more than minPts points, itself included, lie within epsilon and more than 75 % of them have its type. A point with fewer than
/// minPts neighbours is noise, unless it lies within epsilon of a core point of its type, or on sparse surface. With enough
/// neighbours of mixed type it keeps its type, as the thesis' wording has it: a noisy vertical wall mixes all three types and is
/// not noise. The clusters themselves, into which the thesis joins core points, decide nothing and are not numbered.
///
/// Cloud::radius is set for supports that hold Cloud::support_points points at the density of the surface
/// around i: kCleanSupport on a clean scan, up to kNoisySupport where noise must be averaged out.
///
/// @param cloud    in the order of `tree`; normal[].point_class and radius[] are set
/// @param progress  called from the caller's thread only
/// @param arena  clustering_bytes() from the top, released on return
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<ClusteringResult> cluster(Cloud& cloud, const KdTree3& tree, float epsilon, Arena& arena,
                                                 const StageProgress& progress = {},
                                                 SparseSurface sparse = SparseSurface::kKept);

}  // namespace plumbline::inline slicer
