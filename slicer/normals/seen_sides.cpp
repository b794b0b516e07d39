#include "slicer/normals/seen_sides.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/cloud/tangent_plane.hpp"
#include "slicer/normals/sheets.hpp"

namespace plumbline::inline slicer {
namespace {

/// Sine of the angle from the surface below which neighbours decide: 30 degrees. At edges directions are off by as much.
constexpr double kGrazing = 0.5;
constexpr std::uint32_t kVoters = 16;  ///< nearest points that are asked
/// A neighbour votes if its height over the tangent plane is at most this share of its distance. Those on the other side of a wall are higher.
constexpr float kInSurface = 0.25F;

/// Sine of 10 degrees. Where a scanner saw a plane this far from behind, its points are not all on one side of a wall.
constexpr double kBehind = 0.17364818;
constexpr double kAlike = 0.9;  ///< cosine of 26 degrees between the rays of two points: of one view, or nearly
/// Points of one view that make a plane: a strip two pixels wide has as many near each of its points.
constexpr std::uint32_t kPlanePoints = 8;
// Largest ratio of their first variance to the second, and least of the second to the third.
constexpr double kFlat = 0.5;
constexpr double kWide = 0.1;

std::optional<Vec3d> ray_of(const Cloud& cloud, std::uint32_t i) {
  return cloud.views.ray(cloud.view_of(i), cloud.position[i]);
}

/// Sine of the angle between the surface and the ray that saw point i: negative if the normal faces the scanner.
/// @returns 0 if either is not known
double slant(const Cloud& cloud, std::uint32_t i) {
  const auto ray = ray_of(cloud, i);
  return ray ? ray->dot(cloud.normal[i].unpack().cast<double>()) : 0;
}

/// Whether the neighbours in the surface contradict the side that the scanner of point i saw. Each counts as surely as it was seen.
bool is_outvoted(const Cloud& cloud, const KdTree3& tree, std::uint32_t i) {
  std::array<Neighbour, kVoters> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const std::uint32_t count = tree.nearest(cloud.position[i], found);
  const Vec3f normal = cloud.normal[i].unpack();
  double votes = -slant(cloud, i);
  for (const Neighbour& n : std::span(found).first(count)) {
    const float height = normal.dot(cloud.position[n.index] - cloud.position[i]);
    if (n.index == i || height * height > kInSurface * kInSurface * n.distance2) continue;
    votes -= static_cast<double>(join_weight(cloud, i, n.index)) * slant(cloud, n.index);
  }
  return votes < 0;
}

}  // namespace

Vec3f seen_normal(const Cloud& cloud, const KdTree3& tree, std::uint32_t i, const Vec3f& normal,
                  std::span<const Neighbour> points) {
  const auto ray = ray_of(cloud, i);
  if (!ray) return normal;
  const auto facing = [&](const Vec3d& n) { return n.dot(*ray) > 0 ? Vec3d(-n) : n; };
  const Vec3d own = facing(normal.cast<double>());
  const auto from_behind = [&](const Neighbour& n) {
    const auto other = ray_of(cloud, n.index);
    return other && other->dot(own) > kBehind;
  };
  if (-ray->dot(own) > kBehind && std::ranges::none_of(points, from_behind)) return own.cast<float>();
  const auto alike = [&](std::uint32_t j) {
    const auto other = ray_of(cloud, j);
    return other && other->dot(*ray) > kAlike;
  };
  std::array<Neighbour, kPlanePoints> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  if (tree.nearest(cloud.position[i], found, alike) < kPlanePoints) return own.cast<float>();
  const PrincipalAxes of_view = principal_axes(cloud.position[i], found, cloud.position);
  const Vec3d& variance = of_view.variance;
  if (!(variance[0] < kFlat * variance[1] && variance[1] > kWide * variance[2])) return own.cast<float>();
  return facing(of_view.axes.col(0)).cast<float>();
}

Expected<std::uint32_t> face_scanners(Cloud& cloud, const KdTree3& tree, std::span<const std::uint64_t> estimated,
                                      Arena& arena) {
  if (cloud.views.scanners() == 0) return 0U;
  const ArenaScope scope(arena);
  const std::uint32_t words = (cloud.size + 63) / 64;
  std::span<std::uint64_t> turning;
  PLUMBLINE_TRY(arena.take_top(turning, words, "normals"));
  std::uint32_t turned = 0;
  const auto turn = [&](std::uint32_t i) -> std::uint32_t {
    cloud.normal[i].turn_over();
    return estimated.empty() || ((estimated[i / 64] >> (i % 64)) & 1U) == 0 ? 1 : 0;
  };
#pragma omp parallel for schedule(static) reduction(+ : turned)
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (slant(cloud, i) > 0) turned += turn(i);
  }
  // A vote reads the normals around it, so all votes are counted before any normal is turned.
#pragma omp parallel for schedule(dynamic, 16)
  for (std::uint32_t w = 0; w < words; ++w) {
    turning[w] = 0;
    for (std::uint32_t i = w * 64; i < std::min(cloud.size, w * 64 + 64); ++i) {
      const double own = slant(cloud, i);
      if (own < 0 && own > -kGrazing && is_outvoted(cloud, tree, i)) turning[w] |= std::uint64_t{1} << (i % 64);
    }
  }
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (((turning[i / 64] >> (i % 64)) & 1U) != 0) turned += turn(i);
  }
  return turned;
}

}  // namespace plumbline::inline slicer
