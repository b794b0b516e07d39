#include "slicer/surface/bores/bore_surface.hpp"

#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

/// Least share_radius() of a point on a sparse surface, in epsilons. It is 0.13 where about 60 points lie within
/// epsilon, and 0.29 at a fifth of that density.
constexpr float kSparse = 0.3F;
constexpr float kMaxWidth = 8;  ///< epsilons between two walls of a bore; wider ones are seen from outside
// Steps and radii of the search for the opposite wall. It may be as sparse as this one, so the radius grows with the
// distance.
constexpr float kMinStep = 0.5F;      ///< epsilons; also the least width and the least radius
constexpr float kRadiusShare = 0.4F;  ///< of the distance searched so far
constexpr float kStepShare = 0.5F;    ///< of the distance to the nearest point

}  // namespace

BoreSurface::BoreSurface(Cloud& cloud, const KdTree3& tree, const ClusteringResult& clustering)
    : cloud_(cloud),
      tree_(tree),
      clustering_(clustering),
      support_over_share_(std::sqrt(cloud.support_points)),
      scanned_(cloud.size) {}

bool BoreSurface::is_sparse(std::uint32_t i) const {
  return cloud_.radius[i] >= kSparse * epsilon() * support_over_share_;
}

float BoreSurface::distance2(const Vec3f& x) const {
  std::array<Neighbour, 1> found{};
  tree_.nearest(x, found, [&](std::uint32_t i) { return is_surface(i); });
  return found[0].distance2;
}

std::optional<float> BoreSurface::width_at(std::uint32_t i) const {
  const Vec3f n = normal(i);
  const Vec3f& p = cloud_.position[i];
  for (float t = epsilon(); t < kMaxWidth * epsilon();) {
    std::array<Neighbour, 8> found{};
    const std::uint32_t count = tree_.nearest(p + n * t, found, [&](std::uint32_t j) { return is_surface(j); });
    const float search_radius = std::max(kMinStep * epsilon(), kRadiusShare * t);
    for (const Neighbour& other : std::span(found).first(count)) {
      if (other.distance2 > search_radius * search_radius || normal(other.index).dot(n) > -kOneWay) continue;
      const float width = (cloud_.position[other.index] - p).dot(n);
      if (width >= kMinStep * epsilon()) return width;
    }
    t += std::max(kMinStep * epsilon(), kStepShare * std::sqrt(found[0].distance2));
  }
  return std::nullopt;
}

bool BoreSurface::has_wall(const Vec3f& x, const Vec3f& facing) const {
  return any_near(x, [&](const Neighbour& other) {
    const float own = std::max(share_radius(other.index), kSpacing * epsilon());
    return other.distance2 < own * own && normal(other.index).dot(facing) > kOneWay;
  });
}

void BoreSurface::add(const Vec3f& x, const Vec3f& normal) {
  if (full()) return;
  const std::uint32_t i = cloud_.size++;
  cloud_.position[i] = x;
  cloud_.normal[i] = {};
  set_normal(i, normal);
  cloud_.radius[i] = support_over_share_ * kSpacing * epsilon() * std::sqrt(std::numbers::inv_pi_v<float>);
}

void BoreSurface::set_normal(std::uint32_t i, const Vec3f& normal) {
  cloud_.normal[i].set(normal);
  cloud_.normal[i].point_class = orientation_of(cloud_.normal[i]);
}

}  // namespace plumbline
