#include "slicer/layers/feature_limits.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slicer/surface/clustering.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr float kSmallComponent = 50;  ///< epsilon^3; a single outlier makes a component of about 6
constexpr float kSmallFeature =
    2;  ///< epsilon^3. Larger values remove more of the object, smaller ones leave more holes at creases
/// Height of a narrow feature, in epsilons. Creases of the measured clean scans make no higher ones; a larger value
/// removes pins and the stalks of letters.
constexpr float kNarrowHeight = 2.0F / 3;
constexpr float kFlatHeight = 6;  ///< height of a flat feature in standard deviations of the surface: +-3

float voxel_mm3(const PrintGrid& grid) { return grid.pitch_x_mm * grid.pitch_y_mm * grid.layer_height_mm; }

}  // namespace

float widening(float support_points) { return support_points / kCleanSupport; }

ComponentLimits component_limits(PrintLength epsilon, const PrintGrid& grid) {
  const float epsilon_mm = epsilon.value;
  ComponentLimits limits;
  limits.min_voxels =
      static_cast<std::uint64_t>(kSmallComponent * epsilon_mm * epsilon_mm * epsilon_mm / voxel_mm3(grid));
  limits.plate_layers = static_cast<std::uint32_t>(epsilon_mm / grid.layer_height_mm);
  return limits;
}

FeatureLimits feature_limits(float support_points, PrintLength epsilon, PrintLength noise, const PrintGrid& grid) {
  const float epsilon_mm = epsilon.value;
  const float epsilon2 = epsilon_mm * epsilon_mm;
  const float points_of_epsilon = 2 * static_cast<float>(kMinPts);
  const float support_mm2 = std::numbers::pi_v<float> * epsilon2 * support_points / points_of_epsilon;
  const float widened = widening(support_points);
  const float flat_mm = kFlatHeight * noise.value / std::sqrt(std::max(support_points, 1.0F));
  const float pixel_mm2 = grid.pitch_x_mm * grid.pitch_y_mm;
  FeatureLimits limits;
  limits.pixels = static_cast<std::uint32_t>(std::max(support_mm2, epsilon2) / pixel_mm2);
  limits.narrow_pixels = static_cast<std::uint32_t>(epsilon2 / pixel_mm2);
  limits.flat_layers = 1 + static_cast<std::uint32_t>(std::ceil(flat_mm / grid.layer_height_mm));
  const auto creased_layers = static_cast<std::uint32_t>(std::ceil(kNarrowHeight * epsilon_mm / grid.layer_height_mm));
  limits.narrow_layers = widened > 1 ? grid.layers : std::max(limits.flat_layers, creased_layers);
  limits.voxels = static_cast<std::uint64_t>(widened * kSmallFeature * epsilon2 * epsilon_mm / voxel_mm3(grid));
  limits.loose_voxels = component_limits(epsilon, grid).min_voxels;
  return limits;
}

}  // namespace plumbline::inline slicer
