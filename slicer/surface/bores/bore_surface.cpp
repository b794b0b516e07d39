#include "slicer/surface/bores/bore_surface.hpp"

#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

constexpr float kSparse = 0.3F;     ///< of epsilon: the radius of a point's own share of a sparse surface, at least
constexpr float kWidest = 8;        ///< times epsilon
constexpr float kOpposite = -0.5F;  ///< most inner product of the normals of opposite walls
constexpr float kAlike = 0.5F;      ///< least inner product of the normals of one wall
constexpr float kPi = std::numbers::pi_v<float>;

}  // namespace

BoreSurface::BoreSurface(Cloud& cloud, const KdTree3& tree, ClusteringResult& clustering)
    : cloud_(cloud),
      tree_(tree),
      clustering_(clustering),
      growth_(std::sqrt(clustering.support_points)),
      seen_(cloud.size) {}

bool BoreSurface::hardly_seen(std::uint32_t i) const { return cloud_.radius[i] >= kSparse * epsilon() * growth_; }

float BoreSurface::distance2(const Vec3f& x) const {
  std::array<Neighbour, 1> found{};
  tree_.nearest(x, found, [&](std::uint32_t i) { return is_surface(i); });
  return found[0].distance2;
}

std::optional<float> BoreSurface::width_at(std::uint32_t i) const {
  const Vec3f n = normal(i);
  const Vec3f& p = cloud_.position[i];
  for (float t = epsilon(); t < kWidest * epsilon();) {
    std::array<Neighbour, 8> found{};
    const std::uint32_t count = tree_.nearest(p + n * t, found, [&](std::uint32_t j) { return is_surface(j); });
    const float reach = std::max(0.5F * epsilon(), 0.4F * t);  // the wall may be as sparse there
    for (const Neighbour& other : std::span(found).first(count)) {
      if (other.distance2 > reach * reach || normal(other.index).dot(n) > kOpposite) continue;
      const float width = (cloud_.position[other.index] - p).dot(n);
      if (width >= 0.5F * epsilon()) return width;
    }
    t += std::max(0.5F * epsilon(), 0.5F * std::sqrt(found[0].distance2));
  }
  return std::nullopt;
}

bool BoreSurface::has_wall(const Vec3f& x, const Vec3f& facing) const {
  return any_near(x, [&](const Neighbour& other) {
    const float own = std::max(share(other.index), kSpacing * epsilon());
    return other.distance2 < own * own && normal(other.index).dot(facing) > kAlike;
  });
}

void BoreSurface::add(const Vec3f& x, const Vec3f& normal) {
  if (full()) return;
  const std::uint32_t i = cloud_.size++;
  cloud_.position[i] = x;
  cloud_.normal[i] = {};
  cloud_.normal[i].set(normal);
  cloud_.normal[i].point_class = orientation_of(cloud_.normal[i]);
  cloud_.radius[i] = growth_ * kSpacing * epsilon() / std::sqrt(kPi);
}

void BoreSurface::turn(std::uint32_t i, const Vec3f& normal) {
  cloud_.normal[i].set(normal);
  reclass(i, orientation_of(cloud_.normal[i]));
}

void BoreSurface::drop(std::uint32_t i) { reclass(i, PointClass::kNoise); }

void BoreSurface::reclass(std::uint32_t i, PointClass point_class) {
  PointClass& current = cloud_.normal[i].point_class;
  --clustering_.points[static_cast<std::size_t>(current)];
  ++clustering_.points[static_cast<std::size_t>(point_class)];
  current = point_class;
}

}  // namespace plumbline
