#include "slicer/cloud/outliers.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "slicer/cloud/agreement.hpp"
#include "slicer/cloud/tangent_plane.hpp"
#include "slicer/core/loop_progress.hpp"
#include "slicer/core/numbers/median.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kNear = 8;       ///< nearest points that measure a density
constexpr std::uint32_t kSamples = 512;  ///< points whose median density is the scan's
constexpr float kSparse = 2;  ///< times the median distance: a quarter of its density on a surface, an eighth in space
constexpr std::uint32_t kOfSheet = 16;  ///< nearest points that may be a sheet
// Most of the second variance that the least may be. Fewer than 1 of 1,000 points at random have so little.
constexpr double kFlat = 0.1;      ///< of all points
constexpr double kFlatter = 0.03;  ///< of those nearest to their plane
constexpr double kWide = 0.05;  ///< least of the first variance that the second may be: a string of points is no sheet
/// One outlier in so many points, and fewer, are left to the clustering: a few points at open rims and in deep bores look like outliers.
constexpr std::uint32_t kFew = 100;
/// Reaches of the median point within which sparse points are asked among each other: up to 50 times as sparse as the rest 16 are that near.
constexpr float kFar = 5;
// Marks, in place of a radius.
constexpr float kSparsePoint = -1;
constexpr float kOutlier = -2;
constexpr std::uint32_t kBlock = 64;  ///< consecutive points, most of whose neighbours are in their block

class Outliers {
 public:
  Outliers(Cloud& cloud, const KdTree3& tree) : cloud_(cloud), tree_(tree) {}

  Status measure(Arena& arena) {
    const ArenaScope scope(arena);
    const std::uint32_t samples = std::min(kSamples, cloud_.size);
    const auto distance2 = arena.take_top<float>(samples, "outliers");
    PLUMBLINE_TRY(distance2);
    std::array<Neighbour, kNear + 1> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    for (std::uint32_t s = 0; s < samples; ++s) {
      const std::uint32_t count = tree_.nearest(cloud_.position[cloud_.sampled(s, samples)], found);
      (*distance2)[s] = found[count - 1].distance2;
    }
    reach2_ = kSparse * kSparse * median(*distance2);
    return {};
  }

  /// Marks the sparse ones among points [first, last), by their radius.
  void mark_sparse(std::uint32_t first, std::uint32_t last) const {
    for (std::uint32_t i = first; i < last; ++i) cloud_.radius[i] = is_sparse(i, first, last) ? kSparsePoint : 0.0F;
  }

  /// Marks the outliers among sparse points [first, last).
  void mark(std::uint32_t first, std::uint32_t last) const {
    for (std::uint32_t i = first; i < last; ++i) {
      if (!is_marked(i) || is_on_sheet(i) || agrees_with_neighbours(cloud_, tree_, i) || is_on_sparse_sheet(i))
        continue;
      mark_of(i).store(kOutlier, std::memory_order_relaxed);
    }
  }

  std::uint32_t count(float least) const {
    return static_cast<std::uint32_t>(
        std::ranges::count_if(cloud_.radius.first(cloud_.size), [=](float mark) { return mark <= least; }));
  }

 private:
  struct Sheet {
    Vec3d normal = Vec3d::Zero();
    Vec3d mean = Vec3d::Zero();
    double reach2 = 0;  ///< square of the distance of its farthest point; 0: no sheet
  };

  bool is_sparse(std::uint32_t i, std::uint32_t first, std::uint32_t last) const {
    std::uint32_t near = 0;
    for (std::uint32_t j = first; j < last && near <= kNear; ++j) {
      const Vec3f d = cloud_.position[j] - cloud_.position[i];
      near += d.dot(d) <= reach2_ ? 1 : 0;
    }
    if (near > kNear) return false;
    std::array<Neighbour, kNear + 1> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    return tree_.nearest(
               cloud_.position[i], found, [](std::uint32_t) { return true; }, reach2_) <= kNear;
  }

  /// Fits a sheet to the points around a point. If they make none, to the three quarters of them nearest to their plane: the others may be
  /// outliers, or lie beyond an edge.
  Sheet sheet(std::span<Neighbour> around, const Vec3f& from) const {
    const PrincipalAxes all = principal_axes(from, around, cloud_.position);
    if (is_flat(all, kFlat)) return sheet(around, from, all);
    const auto off = [&](const Neighbour& n) {
      return std::abs(all.axes.col(0).dot((cloud_.position[n.index] - from).cast<double>() - all.mean));
    };
    const auto nearer = around.first(around.size() - around.size() / 4);
    std::nth_element(around.begin(), nearer.end(), around.end(),
                     [&](const Neighbour& a, const Neighbour& b) { return off(a) < off(b); });
    const PrincipalAxes most = principal_axes(from, nearer, cloud_.position);
    return is_flat(most, kFlatter) ? sheet(nearer, from, most) : Sheet();
  }
  static bool is_flat(const PrincipalAxes& axes, double least) {
    return axes.variance[0] <= least * axes.variance[1] && axes.variance[1] > kWide * axes.variance[2];
  }
  static Sheet sheet(std::span<const Neighbour> points, const Vec3f& from, const PrincipalAxes& axes) {
    Sheet sheet{axes.axes.col(0), from.cast<double>() + axes.mean, 0};
    for (const Neighbour& n : points) sheet.reach2 = std::max(sheet.reach2, static_cast<double>(n.distance2));
    return sheet;
  }
  static bool lies_on(const Sheet& sheet, const Vec3f& p, double distance2) {
    const double height = sheet.normal.dot(p.cast<double>() - sheet.mean);
    return distance2 <= sheet.reach2 && height * height <= static_cast<double>(kMostHeight * kMostHeight) * distance2;
  }

  std::atomic_ref<float> mark_of(std::uint32_t i) const { return std::atomic_ref(cloud_.radius[i]); }
  bool is_marked(std::uint32_t i) const { return mark_of(i).load(std::memory_order_relaxed) != 0; }

  bool is_on_sheet(std::uint32_t i) const {
    const Vec3f& p = cloud_.position[i];
    std::array<Neighbour, kOfSheet + 1> around;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    const std::uint32_t count = tree_.nearest(p, around);
    if (count <= kOfSheet) return true;
    std::array<Neighbour, kNear> nearest;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    std::copy_n(around.begin() + 1, kNear, nearest.begin());
    if (lies_on(sheet(around, p), p, static_cast<double>(nearest.back().distance2))) return true;
    return std::any_of(nearest.begin(), nearest.end(), [&](const Neighbour& n) {
      std::array<Neighbour, kOfSheet + 1> of_other;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      const Vec3f& other = cloud_.position[n.index];
      tree_.nearest(other, of_other);
      return lies_on(sheet(of_other, other), p, static_cast<double>(n.distance2));
    });
  }

  /// Whether a sparse point lies on a sheet of others that are sparse.
  bool is_on_sparse_sheet(std::uint32_t i) const {
    const Vec3f& p = cloud_.position[i];
    std::array<Neighbour, kOfSheet + 1> around;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    const auto sparse = [&](std::uint32_t j) { return is_marked(j); };
    if (tree_.nearest(p, around, sparse, kFar * kFar * reach2_) <= kOfSheet) return false;
    const PrincipalAxes all = principal_axes(p, around, cloud_.position);
    return is_flat(all, kFlat) && lies_on(sheet(around, p, all), p, static_cast<double>(around[kNear].distance2));
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  float reach2_ = 0;  ///< square of the distance within which the eighth nearest of a point lies that is not sparse
};

}  // namespace

std::size_t outliers_bytes(std::uint32_t points) { return Arena::rounded(sizeof(float) * std::min(kSamples, points)); }

Expected<std::uint32_t> drop_outliers(Cloud& cloud, const KdTree3& tree, Arena& arena, const StageProgress& progress) {
  Outliers outliers(cloud, tree);
  PLUMBLINE_TRY(outliers.measure(arena));
  const auto are_few = [&](float mark) { return std::uint64_t{kFew} * outliers.count(mark) < cloud.size; };
  const auto sparse = [&](std::uint32_t first, std::uint32_t last) { outliers.mark_sparse(first, last); };
  const auto mark = [&](std::uint32_t first, std::uint32_t last) { outliers.mark(first, last); };
  if (!for_blocks(cloud.size, kBlock, progress.part(0, 0.5), sparse) ||
      (!are_few(kSparsePoint) && !for_blocks(cloud.size, kBlock, progress.part(0.5, 1), mark))) {
    return fail(ErrorCode::kCancelled, "cancelled while outliers were looked for");
  }
  if (are_few(kOutlier)) return 0U;
  const std::uint32_t count = outliers.count(kOutlier);
  cloud.keep([&](std::uint32_t i) { return cloud.radius[i] > kOutlier; });
  return count;
}

}  // namespace plumbline::inline slicer
