#include "slicer/surface/sparse_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/cloud/neighbourhood.hpp"
#include "slicer/core/loop_progress.hpp"

namespace plumbline {
namespace {

/// Nearest points searched: more than the 5 needed, since some are too far by the metric of the clustering.
constexpr std::uint32_t kSearch = 16;
constexpr float kRounded = 1.001F;  ///< of normals: the square of their length is 1 at most but for this

}  // namespace

std::optional<float> sparse_surface_radius(const Cloud& cloud, const KdTree3& tree, std::uint32_t i, float epsilon) {
  std::array<Neighbour, kSearch> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const float radius2 = kSparseRadius * epsilon * kSparseRadius * epsilon;
  const Vec3f normal = cloud.normal[i].unpack();
  // Behind a thin wall the points of the other side may be nearer, and many more.
  const auto faces_its_way = [&](std::uint32_t other) { return cloud.normal[other].unpack().dot(normal) > 0; };
  const std::uint32_t count = tree.nearest(cloud.position[i], found, faces_its_way, kRounded * radius2);
  std::uint32_t near = 0;
  float farthest2 = 0;
  float height = 0;
  float distance = 0;
  for (std::uint32_t k = 0; k < count && near < kSparsePoints; ++k) {
    const Vec3f other = cloud.normal[found[k].index].unpack();
    if (!Within{found[k].distance2, normal.dot(other)}.near(radius2)) continue;
    ++near;
    farthest2 = found[k].distance2;
    height += 0.5F * (normal + other).dot(cloud.position[i] - cloud.position[found[k].index]);
    distance += std::sqrt(farthest2);
  }
  if (near < kSparsePoints || std::abs(height) > kMostHeight * distance) return std::nullopt;
  return std::sqrt(farthest2 / static_cast<float>(near));
}

Status rescue_sparse_surface(Cloud& cloud, const KdTree3& tree, float epsilon, const StageProgress& progress) {
  const float growth = std::sqrt(cloud.support_points);
  const auto rescue_block = [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t i = first; i < last; ++i) {
      PackedNormal& normal = cloud.normal[i];
      if (cloud.is_surface(i) || !normal.known()) continue;
      // Reads no class or radius of another point, so the order of the points does not matter.
      const auto radius = sparse_surface_radius(cloud, tree, i, epsilon);
      if (!radius) continue;
      normal.point_class = orientation_of(normal);
      cloud.radius[i] = std::max(cloud.radius[i], growth * *radius);
    }
  };
  if (for_blocks(cloud.size, kSharedSearch, progress, rescue_block)) return {};
  return fail(ErrorCode::kCancelled, "cancelled while sparse parts of the surface were looked for");
}

}  // namespace plumbline
