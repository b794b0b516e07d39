#include "slicer/normals/normals.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/cloud/tangent_plane.hpp"
#include "slicer/core/loop_progress.hpp"
#include "slicer/normals/false_scanners.hpp"
#include "slicer/normals/flipped_normals.hpp"
#include "slicer/normals/normal_orientation.hpp"
#include "slicer/normals/seen_sides.hpp"

namespace plumbline::inline slicer {
namespace {

/// Cosine of 30 degrees: a splat whose axis is farther from the normal of its neighbours' plane takes that. The axes of splats that
/// training has left round or turned mean nothing. One of seven random directions is as near.
constexpr float kSplatAgrees = 0.86602540F;

// Points at which the scan's normals are compared with the surface, and the nearest points that stand for it: enough to be wider than noise.
constexpr std::uint32_t kCompared = 256;
constexpr std::uint32_t kOfSurface = 64;
/// Of the way from the best normals (0) to random ones (1), beyond which they are not the surface's. Scans have up to 0.2, directions to
/// several scanners 0.6 to 0.7, one direction for all points 0.5 (a flat gear) to 1.
constexpr double kLeastRandom = 0.35;
/// Share of the least of the three variances, above which points are a cloud and no surface. Random points around a point have 0.2 to 0.3.
constexpr double kOfCloud = 0.1;

/// Whether the directions of the normals are not those of the surface. Programs write one direction for all points, that to the scanner, or
/// swapped axes.
///
///   v(n) = <n, C n> / trace C,   C the covariance of a point's nearest
///
/// is least for the normal of their plane and 1/3 in the mean of all directions.
bool are_foreign(const Cloud& cloud, const KdTree3& tree) {
  std::array<Neighbour, kOfSurface> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  double given = 0;
  double best = 0;
  double random = 0;
  const std::uint32_t samples = std::min(kCompared, cloud.size);
  for (std::uint32_t s = 0; s < samples; ++s) {
    const std::uint32_t i = cloud.sampled(s, samples);
    if (!cloud.normal[i].known()) continue;
    const std::uint32_t count = tree.nearest(cloud.position[i], found);
    const PrincipalAxes around = principal_axes(cloud.position[i], std::span(found).first(count), cloud.position);
    const Vec3d& variance = around.variance;
    const double sum = variance[0] + variance[1] + variance[2];
    if (!(variance[0] < kOfCloud * sum)) continue;
    const Vec3d normal = cloud.normal[i].unpack().cast<double>();
    for (int axis = 0; axis < 3; ++axis) {
      const double along = around.axes.col(axis).dot(normal);
      given += along * along * variance[axis] / sum;
    }
    best += variance[0] / sum;
    random += 1.0 / 3;
  }
  return given - best > kLeastRandom * (random - best);
}

}  // namespace

std::size_t normals_bytes(std::uint32_t points) {
  return std::max(orientation_bytes(points) + (points + 7) / 8, flipped_normals_bytes(points));
}

Expected<NormalCounts> estimate_normals(Cloud& cloud, const KdTree3& tree, Arena& arena, const StageProgress& progress,
                                        NormalSides sides) {
  const ArenaScope scope(arena);
  const std::uint32_t size = cloud.size;
  const std::uint32_t words = (size + 63) / 64;
  std::span<std::uint64_t> estimated;
  PLUMBLINE_TRY(arena.take_top(estimated, words, "normals"));
  std::uint32_t filled = 0;
  LoopProgress estimating(progress.part(0, 0.7), words);
#pragma omp parallel for schedule(dynamic, 16) reduction(+ : filled)
  for (std::uint32_t w = 0; w < words; ++w) {
    if (!estimating.step(w)) continue;
    std::uint64_t word = 0;
    const std::uint32_t last = std::min(size, w * 64 + 64);
    TangentPlanes planes(cloud, tree);
    for (std::uint32_t i = w * 64; i < last; ++i) {
      planes.look_at(i);
      cloud.radius[i] = planes.share_radius();
      const PackedNormal own = cloud.normal[i];
      if (own.known() && sides == NormalSides::kKnown) continue;
      const auto normal = planes.normal();
      if (own.known()) word |= std::uint64_t{1} << (i % 64);
      if (!normal || (own.known() && std::abs(own.unpack().dot(*normal)) >= kSplatAgrees)) continue;
      cloud.normal[i].set(seen_normal(cloud, tree, i, *normal, planes.points()));
      word |= std::uint64_t{1} << (i % 64);
      ++filled;
    }
    estimated[w] = word;
  }
  if (estimating.stopped()) return fail(ErrorCode::kCancelled, "cancelled while estimating normals");
  const auto turned = face_scanners(cloud, tree, estimated, arena);
  PLUMBLINE_TRY(turned);
  if (filled > 0 || sides == NormalSides::kUnknown) {
    PLUMBLINE_TRY(orient_normals(cloud, tree, estimated, arena, progress.part(0.7, 1)));
  }
  return NormalCounts{.estimated = filled, .turned = *turned};
}

Expected<NormalCounts> complete_normals(Cloud& cloud, const KdTree3& tree, Arena& arena, const StageProgress& progress,
                                        NormalSides sides) {
  forget_false_scanners(cloud, tree);
  const auto normals = cloud.normal.first(cloud.size);
  const auto missing = static_cast<std::uint32_t>(
      std::count_if(normals.begin(), normals.end(), [](const PackedNormal& n) { return !n.known(); }));
  if (missing < cloud.size && are_foreign(cloud, tree)) sides = NormalSides::kUnknown;
  NormalCounts counts;
  if (missing > 0 || sides == NormalSides::kUnknown) {
    const auto estimated = estimate_normals(cloud, tree, arena, progress.part(0, 0.7), sides);
    PLUMBLINE_TRY(estimated);
    counts = *estimated;
  } else {
    const auto turned = face_scanners(cloud, tree, {}, arena);
    PLUMBLINE_TRY(turned);
    counts.turned = *turned;
  }
  if (missing == cloud.size || sides == NormalSides::kUnknown) return counts;
  auto flipped = turn_flipped_normals(cloud, tree, arena, missing > 0 ? progress.part(0.7, 1) : progress);
  if (flipped) {
    flipped->estimated = counts.estimated;
    flipped->turned += counts.turned;
  }
  return flipped;
}

}  // namespace plumbline::inline slicer
