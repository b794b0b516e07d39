#include "slicer/surface/sparse_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "slicer/cloud/agreement.hpp"
#include "slicer/cloud/neighbourhood.hpp"
#include "slicer/core/loop_progress.hpp"
#include "slicer/core/numbers/median.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kMayDiffer = 2;  ///< of kSparsePoints
/// Epsilons. Up to 400 times as sparse as most of the scan, a sheet has kSparsePoints points within it.
constexpr float kFarthest = 8;
/// Nearest points searched: more than are needed, since some are too far by the metric of the clustering.
constexpr std::uint32_t kSearch = 24;
constexpr std::uint32_t kAround = 8;  ///< nearest points whose supports are compared with a wide one
constexpr float kWiderThan = 1.25F;   ///< times their median
constexpr float kRounded = 1.001F;    ///< of normals: the square of their length is 1 at most but for this

}  // namespace

std::optional<float> sparse_share(const Cloud& cloud, const KdTree3& tree, std::uint32_t i, float epsilon) {
  std::array<Neighbour, kSearch> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const auto square = [&](float epsilons) { return epsilons * epsilon * epsilons * epsilon; };
  const Vec3f normal = cloud.normal[i].unpack();
  // Behind a thin wall the points of the other side may be nearer, and many more.
  const auto faces_its_way = [&](std::uint32_t other) { return cloud.normal[other].unpack().dot(normal) > 0; };
  const std::uint32_t count = tree.nearest(cloud.position[i], found, faces_its_way, kRounded * square(kFarthest));
  std::uint32_t near = 0;
  std::uint32_t agreeing = 0;
  float farthest2 = 0;
  float height = 0;
  float distance = 0;
  for (std::uint32_t k = 0; k < count && near < kSparsePoints; ++k) {
    const Neighbour& other = found[k];
    if (!Within{other.distance2, normal.dot(cloud.normal[other.index].unpack())}.near(square(kFarthest))) continue;
    ++near;
    farthest2 = other.distance2;
    agreeing += agree(cloud, i, other) ? 1 : 0;
    height += pair_height(cloud, i, other.index);
    distance += std::sqrt(farthest2);
  }
  if (near < kSparsePoints || std::abs(height) > kMostHeight * distance) return std::nullopt;
  if (farthest2 > square(kSparseRadius) && agreeing + kMayDiffer < kSparsePoints) return std::nullopt;
  if (opposed(cloud, tree, i) == Opposed::kBeside) return std::nullopt;
  return std::sqrt(farthest2 / static_cast<float>(near));
}

Status rescue_sparse_surface(Cloud& cloud, const KdTree3& tree, float epsilon, const StageProgress& progress) {
  const float growth = std::sqrt(cloud.support_points);
  const auto rescue_block = [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t i = first; i < last; ++i) {
      PackedNormal& normal = cloud.normal[i];
      if (cloud.is_surface(i) || !normal.known()) continue;
      // Reads no class or radius of another point, so the order of the points does not matter.
      const auto share = sparse_share(cloud, tree, i, epsilon);
      if (!share) continue;
      normal.point_class = orientation_of(normal);
      cloud.radius[i] = std::max(cloud.radius[i], growth * *share);
    }
  };
  if (for_blocks(cloud.size, kSharedSearch, progress, rescue_block)) return {};
  return fail(ErrorCode::kCancelled, "cancelled while sparse parts of the surface were looked for");
}

Status level_wide_supports(Cloud& cloud, const KdTree3& tree, float epsilon, Arena& arena) {
  const ArenaScope scope(arena);
  const auto levelled = arena.take_top<float>(cloud.size, "wide supports");
  PLUMBLINE_TRY(levelled);
  const float usual = usual_support(epsilon, cloud.support_points);
#pragma omp parallel for schedule(dynamic, 256)
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    float& radius = (*levelled)[i] = cloud.radius[i];
    if (!(radius > usual) || !cloud.is_surface(i)) continue;
    const Vec3f normal = cloud.normal[i].unpack();
    const auto counts = [&](std::uint32_t other) {
      return other != i && cloud.is_surface(other) && cloud.normal[other].unpack().dot(normal) > 0;
    };
    std::array<Neighbour, kAround> near;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    std::array<float, kAround> radii{};
    const std::uint32_t count = tree.nearest(cloud.position[i], near, counts);
    if (count == 0) continue;
    for (std::uint32_t k = 0; k < count; ++k) radii[k] = cloud.radius[near[k].index];
    radius = std::max(usual, std::min(radius, kWiderThan * median(std::span(radii).first(count))));
  }
  std::ranges::copy(*levelled, cloud.radius.begin());
  return {};
}

}  // namespace plumbline::inline slicer
