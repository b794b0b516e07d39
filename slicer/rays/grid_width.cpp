#include "slicer/rays/grid_width.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kNeighbour = 10;  ///< k_2 of the thesis
constexpr std::uint32_t kSample = 8192;   ///< points of a class, evenly spaced by index

/// Mean distance in the plane to the k_2-th nearest other point of the class, infinite where there is none.
double mean_distance(const Cloud& cloud, const KdTree2& tree, PointClass of) {
  std::uint32_t members = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) members += cloud.normal[i].point_class == of ? 1 : 0;
  if (members <= kNeighbour) return std::numeric_limits<double>::infinity();
  const std::uint32_t step = std::max<std::uint32_t>(1, members / kSample);
  std::array<Neighbour, kNeighbour + 1> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  double sum = 0;
  std::uint32_t samples = 0;
  std::uint32_t member = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (cloud.normal[i].point_class != of || member++ % step != 0) continue;
    const std::uint32_t k =
        tree.nearest(cloud.position[i], found, [&](std::uint32_t j) { return cloud.normal[j].point_class == of; });
    sum += std::sqrt(static_cast<double>(found[k - 1].distance2));
    ++samples;
  }
  return sum / samples;
}

}  // namespace

float grid_width(const Cloud& cloud, const KdTree2& tree) {
  double least = std::numeric_limits<double>::infinity();
#pragma omp parallel for schedule(static, 1) reduction(min : least)
  for (int side = 0; side < 2; ++side) {
    least = std::min(least, mean_distance(cloud, tree, side == 0 ? PointClass::kEntering : PointClass::kExiting));
  }
  return std::isfinite(least) ? std::sqrt(std::numbers::pi_v<float>) * static_cast<float>(least) : 0.0F;
}

}  // namespace plumbline::inline slicer
