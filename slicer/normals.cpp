#include "slicer/normals.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/loop_progress.hpp"
#include "slicer/normal_orientation.hpp"
#include "slicer/turned_patches.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "normals";

/// Points of a plane. The next size is tried where one does not suffice; the last ones are for noise as large as the spacing.
constexpr std::array<std::uint32_t, 3> kPlanePoints = {20, 40, 80};
constexpr std::uint32_t kMostPlanePoints = kPlanePoints.back();

/// A neighbourhood suffices if it reaches this many residuals far. A right edge has 5.3, a ball of points 2.2.
constexpr double kReachInResiduals = 4;
/// and if its second variance is at least this share of the first: a disc has 1, a half disc 0.28, a scan line nearly 0.
constexpr double kLeastWidth = 0.05;
/// Below this share there is no plane: the points lie on a line or in one place.
constexpr double kLine = 1e-6;

constexpr double kCompletionShare = 0.7;  ///< of the time for what a scan lacks; what it has wrong takes the rest
constexpr double kEstimateShare = 0.7;    ///< of the time; turning them takes the rest

struct Plane {
  Vec3d normal = Vec3d::Zero();
  double flatness = -1;  ///< second variance over least: larger is better. Below 0: no plane
  bool sufficient = false;
};

Plane fit_plane(const Vec3f& point, std::span<const Neighbour> neighbours, const Cloud& cloud) {
  const auto count = static_cast<double>(neighbours.size());
  Vec3d sum = Vec3d::Zero();  // from `point`, so that nothing large cancels
  Mat3d products = Mat3d::Zero();
  for (const Neighbour& n : neighbours) {
    const Vec3d d = (cloud.position[n.index] - point).cast<double>();
    sum += d;
    products += d * d.transpose();
  }
  const Mat3d scatter = products - sum * (sum.transpose() / count);
  // compute(), not computeDirect(): the closed form takes sines, which differ from one C library to another.
  const Eigen::SelfAdjointEigenSolver<Mat3d> solver(scatter);
  const Vec3d& variance = solver.eigenvalues();
  Plane plane;
  if (!(variance[1] > kLine * variance[2])) return plane;
  const double least = std::max(variance[0], 1e-12 * variance[2]);
  plane.normal = solver.eigenvectors().col(0);
  plane.flatness = variance[1] / least;
  const auto reach2 = static_cast<double>(neighbours.back().distance2);
  plane.sufficient =
      reach2 >= kReachInResiduals * kReachInResiduals * least / count && variance[1] >= kLeastWidth * variance[2];
  return plane;
}

/// Goes from point to point of a run, which lie near each other: what sufficed for one is what the next will need.
class Estimator {
 public:
  Estimator(Cloud& cloud, const KdTree3& tree) : cloud_(cloud), tree_(tree) {}

  /// Sets the share of the surface of point i, and its normal if it has none.
  /// @returns whether the normal was set
  bool operator()(std::uint32_t i) {
    const Vec3f point = cloud_.position[i];
    std::uint32_t have = 0;  // nearest points found so far
    Plane best;
    for (std::size_t size = 0; size < kPlanePoints.size(); ++size) {
      const std::uint32_t wanted = kPlanePoints[size];
      if (have < wanted) have = tree_.nearest(point, std::span(found_).first(kPlanePoints[std::max(size, expected_)]));
      const std::uint32_t count = std::min(have, wanted);
      if (size == 0) {
        cloud_.radius[i] = std::sqrt(found_[count - 1].distance2 / static_cast<float>(count));
        if (cloud_.normal[i].known()) return false;
      }
      if (count < 3) break;
      const Plane plane = fit_plane(point, std::span(found_).first(count), cloud_);
      if (plane.flatness > best.flatness) best = plane;
      if (plane.sufficient || size + 1 == kPlanePoints.size()) expected_ = size;
      if (plane.sufficient || count < wanted) break;
    }
    if (best.flatness < 0) return false;
    cloud_.normal[i].set(best.normal.cast<float>());
    return true;
  }

 private:
  Cloud& cloud_;
  const KdTree3& tree_;
  std::size_t expected_ = 0;                       ///< saves searches, changes no result
  std::array<Neighbour, kMostPlanePoints> found_;  // NOLINT(cppcoreguidelines-pro-type-member-init)
};

}  // namespace

std::size_t normals_bytes(std::uint32_t points) {
  return std::max(orientation_bytes(points) + (points + 7) / 8, turned_patches_bytes(points));
}

Expected<std::uint32_t> estimate_normals(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                         const StageProgress& progress) {
  const ArenaScope scope(arena);
  const std::uint32_t size = cloud.size;
  const std::uint32_t words = (size + 63) / 64;
  auto bits = arena.take_top<std::uint64_t>(words, kStage);
  if (!bits) return tl::unexpected<Error>(bits.error());
  const std::span<std::uint64_t> estimated = *bits;
  std::uint32_t filled = 0;
  LoopProgress estimating(progress.part(0, kEstimateShare), words);
#pragma omp parallel for schedule(dynamic, 16) reduction(+ : filled)
  for (std::uint32_t w = 0; w < words; ++w) {
    if (!estimating.step(w)) continue;
    std::uint64_t word = 0;
    const std::uint32_t last = std::min(size, w * 64 + 64);
    Estimator estimate(cloud, tree);
    for (std::uint32_t i = w * 64; i < last; ++i) {
      if (!estimate(i)) continue;
      word |= std::uint64_t{1} << (i % 64);
      ++filled;
    }
    estimated[w] = word;
  }
  if (estimating.stopped()) return fail(ErrorCode::kCancelled, "cancelled while normals were estimated");
  if (filled > 0) PLUMBLINE_TRY(orient_normals(cloud, tree, estimated, arena, progress.part(kEstimateShare, 1)));
  return filled;
}

Expected<NormalCounts> complete_normals(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                        const StageProgress& progress) {
  const auto normals = cloud.normal.first(cloud.size);
  const auto missing = std::count_if(normals.begin(), normals.end(), [](const PackedNormal& n) { return !n.known(); });
  NormalCounts counts;
  if (missing > 0) {
    const auto estimated = estimate_normals(cloud, tree, arena, progress.part(0, kCompletionShare));
    PLUMBLINE_TRY(estimated);
    counts.estimated = *estimated;
  }
  if (static_cast<std::uint32_t>(missing) == cloud.size) return counts;
  const auto turned = turn_patches(cloud, tree, arena, missing > 0 ? progress.part(kCompletionShare, 1) : progress);
  PLUMBLINE_TRY(turned);
  counts.turned = *turned;
  return counts;
}

}  // namespace plumbline
