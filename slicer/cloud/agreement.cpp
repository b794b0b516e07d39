#include "slicer/cloud/agreement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kFacing = 5;       ///< nearest points that face a point's way
constexpr std::ptrdiff_t kMostFacing = 4;  ///< of these, that must agree with it
/// Nearest points that opposed() asks. They must reach farther than the noise is high: of eight, noisy points above and below each
/// other hide the side of their sheet.
constexpr std::uint32_t kAsked = 32;
constexpr float kBeside = 0.5F;  ///< sine of 30 degrees

}  // namespace

float pair_height(const Cloud& cloud, std::uint32_t i, std::uint32_t j) {
  return 0.5F * (cloud.normal[i].unpack() + cloud.normal[j].unpack()).dot(cloud.position[i] - cloud.position[j]);
}

bool agree(const Cloud& cloud, std::uint32_t i, const Neighbour& other) {
  return cloud.normal[i].unpack().dot(cloud.normal[other.index].unpack()) > kOneWay &&
         std::abs(pair_height(cloud, i, other.index)) <= kMostHeight * std::sqrt(other.distance2);
}

bool agrees_with_neighbours(const Cloud& cloud, const KdTree3& tree, std::uint32_t i, float reach) {
  if (!cloud.normal[i].known()) return false;
  const Vec3f n = cloud.normal[i].unpack();
  const auto faces_its_way = [&](std::uint32_t j) { return j != i && cloud.normal[j].unpack().dot(n) > kOneWay; };
  std::array<Neighbour, kFacing> around;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const std::uint32_t count = tree.nearest(cloud.position[i], around, faces_its_way, reach * reach);
  const auto agrees = [&](const Neighbour& other) { return agree(cloud, i, other); };
  return std::count_if(around.begin(), around.begin() + count, agrees) >= kMostFacing;
}

Opposed opposed(const Cloud& cloud, const KdTree3& tree, std::uint32_t i) {
  std::array<Neighbour, kAsked> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const Vec3f normal = cloud.normal[i].unpack();
  const std::uint32_t count = tree.nearest(cloud.position[i], found, [i](std::uint32_t other) { return other != i; });
  std::uint32_t beside = 0;
  std::uint32_t behind = 0;
  for (const Neighbour& other : std::span(found).first(count)) {
    const Vec3f against = -cloud.normal[other.index].unpack();
    if (!(normal.dot(against) > kOneWay)) continue;
    const float height = 0.5F * (normal + against).dot(cloud.position[i] - cloud.position[other.index]);
    ++(height * height < kBeside * kBeside * other.distance2 ? beside : behind);
  }
  if (2 * beside > count) return Opposed::kBeside;
  return 2 * behind > count ? Opposed::kBehind : Opposed::kNowhere;
}

}  // namespace plumbline::inline slicer
