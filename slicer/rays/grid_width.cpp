#include "slicer/rays/grid_width.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace plumbline {
namespace {

constexpr float kSqrtPi = 1.77245385F;

/// Mean distance in the plane to the k-th nearest other point of the class, infinite where there is none.
double mean_distance(const Cloud& cloud, const KdTree2& tree, PointClass of, const GridWidthSettings& settings) {
  std::uint32_t members = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) members += cloud.normal[i].point_class == of ? 1 : 0;
  if (members <= settings.neighbour) return std::numeric_limits<double>::infinity();
  const std::uint32_t step = std::max<std::uint32_t>(1, members / settings.sample);
  std::array<Neighbour, 64> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const std::span<Neighbour> wanted = std::span(found).first(std::min<std::size_t>(64, settings.neighbour + 1));
  double sum = 0;
  std::uint32_t samples = 0;
  std::uint32_t member = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (cloud.normal[i].point_class != of || member++ % step != 0) continue;
    const std::uint32_t k =
        tree.nearest(cloud.position[i], wanted, [&](std::uint32_t j) { return cloud.normal[j].point_class == of; });
    sum += std::sqrt(static_cast<double>(found[k - 1].distance2));
    ++samples;
  }
  return sum / samples;
}

}  // namespace

float grid_width(const Cloud& cloud, const KdTree2& tree, const GridWidthSettings& settings) {
  constexpr std::array kClasses = {PointClass::kEntering, PointClass::kExiting};
  std::array<double, 2> distances = {};
#pragma omp parallel for schedule(static, 1)
  for (std::size_t i = 0; i < kClasses.size(); ++i) {
    distances[i] = mean_distance(cloud, tree, kClasses[i], settings);
  }
  const double least = std::min(distances[0], distances[1]);
  return std::isfinite(least) ? kSqrtPi * static_cast<float>(least) : 0.0F;
}

}  // namespace plumbline
