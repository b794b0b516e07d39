#include "slicer/cloud/even_spacing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "slicer/cloud/point_groups.hpp"
#include "slicer/cloud/tangent_plane.hpp"
#include "slicer/core/numbers/median.hpp"

namespace plumbline::inline slicer {
namespace {

/// Nearest points of the narrowest neighbourhood: those of the tangent planes.
constexpr std::uint32_t kFewest = 20;
/// Those of the widest, that of lines 60 spacings apart.
constexpr std::uint32_t kMost = 320;
/// A neighbourhood is wide enough if its second variance is at least this share of the first. A disc has 1, a half disc 0.28; 20 points of a
/// line whose noise is as wide as they are apart .12.
constexpr double kWide = 0.25;
/// Radii of a wide enough neighbourhood within which neighbours are averaged: it then holds some 20 points.
constexpr float kAveraged = 0.25F;
constexpr std::uint32_t kBlock = 64;     ///< consecutive points that are averaged with each other
constexpr std::uint32_t kPlaces = 5;     ///< of a block, where it is measured
constexpr std::uint32_t kSamples = 256;  ///< points that tell whether there are lines
constexpr std::uint32_t kFewLines = 8;   ///< one sample in so many is at an edge

using Widest = std::array<Neighbour, kMost>;

/// The radius of a neighbourhood that is wide enough; 0: the narrowest is.
float wide_radius(const Cloud& cloud, const KdTree3& tree, std::uint32_t i, Widest& room) {
  std::uint32_t count = 0;
  for (std::uint32_t wanted = kFewest; wanted <= kMost; wanted *= 2) {
    count = tree.nearest(cloud.position[i], std::span(room).first(wanted));
    const Vec3d variance = principal_axes(cloud.position[i], std::span(room).first(count), cloud.position).variance;
    if (variance[1] >= kWide * variance[2]) return wanted == kFewest ? 0.0F : std::sqrt(room[count - 1].distance2);
  }
  return 0;  // a single line
}

struct LinePoint {
  Vec3f position;
  PackedNormal normal;
  std::uint8_t view;
};

bool has_lines(const Cloud& cloud, const KdTree3& tree) {
  const std::uint32_t samples = std::min(kSamples, cloud.size);
  std::uint32_t lines = 0;
#pragma omp parallel for schedule(dynamic, 16) reduction(+ : lines)
  for (std::uint32_t s = 0; s < samples; ++s) {
    Widest room;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    lines += wide_radius(cloud, tree, cloud.sampled(s, samples), room) > 0 ? 1 : 0;
  }
  return kFewLines * lines > samples;
}

}  // namespace

std::uint32_t even_out_lines(Cloud& cloud, const KdTree3& tree) {
  if (!has_lines(cloud, tree)) return 0;
  const std::uint32_t blocks = (cloud.size + kBlock - 1) / kBlock;
  // Normals and clustering use radius[] later. Until then a block keeps its cube's side in that of its first point.
#pragma omp parallel for schedule(dynamic, 16)
  for (std::uint32_t b = 0; b < blocks; ++b) {
    const std::uint32_t first = b * kBlock;
    const std::uint32_t size = std::min(kBlock, cloud.size - first);
    Widest room;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    std::array<float, kPlaces> radii{};
    for (std::uint32_t p = 0; p < kPlaces; ++p) {
      radii[p] = wide_radius(cloud, tree, first + (2 * p + 1) * size / (2 * kPlaces), room);
    }
    cloud.radius[first] = kAveraged * median(std::span<float>(radii));
  }
  std::uint32_t kept = 0;
  for (std::uint32_t b = 0; b < blocks; ++b) {
    const std::uint32_t first = b * kBlock;
    const std::uint32_t size = std::min(kBlock, cloud.size - first);
    const float side = cloud.radius[first];
    std::array<LinePoint, kBlock> points;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    for (std::uint32_t k = 0; k < size; ++k) {
      points[k] = {cloud.position[first + k], cloud.normal[first + k], cloud.view_of(first + k)};
    }
    const auto in_cube = [side](std::span<const LinePoint>, float longest) { return !(longest > side); };
    const auto average = [&](std::span<const LinePoint> group) {
      Vec3f sum = Vec3f::Zero();
      Vec3f normal = Vec3f::Zero();
      std::uint32_t weight = 0;
      for (const LinePoint& p : group) {
        sum += p.position - group[0].position;
        normal += p.normal.unpack();
        weight += p.normal.weight;
      }
      cloud.position[kept] = group[0].position + sum / static_cast<float>(group.size());
      if (cloud.views) cloud.views.of[kept] = group[0].view;
      cloud.normal[kept].set(normal);
      cloud.normal[kept++].weight = static_cast<std::uint8_t>(std::min(weight, 255U));
    };
    for_each_group(
        std::span(points).first(size), [](const LinePoint& p) -> const Vec3f& { return p.position; }, in_cube, average);
  }
  const std::uint32_t averaged = cloud.size - kept;
  cloud.size = kept;
  return averaged;
}

}  // namespace plumbline::inline slicer
