#include "slicer/stray_limits.hpp"

namespace plumbline {
namespace {

constexpr float kSpeck = 50;
constexpr float kFeature = 2;

float voxel_mm3(const PrintGrid& grid) { return grid.pitch_x_mm * grid.pitch_y_mm * grid.layer_height_mm; }

}  // namespace

PieceLimits piece_limits(const ClusteringResult& clustering, const PrintGrid& grid) {
  const float epsilon = clustering.epsilon;
  PieceLimits limits;
  limits.speck_voxels = static_cast<std::uint64_t>(kSpeck * epsilon * epsilon * epsilon / voxel_mm3(grid));
  limits.plate_layers = static_cast<std::uint32_t>(epsilon / grid.layer_height_mm);
  return limits;
}

FeatureLimits feature_limits(const ClusteringResult& clustering, float supports_widened, const PrintGrid& grid) {
  const float epsilon2 = clustering.epsilon * clustering.epsilon;
  FeatureLimits limits;
  limits.pixels = static_cast<std::uint32_t>(kFeature * epsilon2 / (grid.pitch_x_mm * grid.pitch_y_mm));
  limits.voxels =
      static_cast<std::uint64_t>(supports_widened * kFeature * epsilon2 * clustering.epsilon / voxel_mm3(grid));
  return limits;
}

}  // namespace plumbline
