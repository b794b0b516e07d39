#include "slicer/layers/feature_limits.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "slicer/surface/clustering.hpp"

namespace plumbline {
namespace {

constexpr float kNoise = 0.09F;  // mm

/// A flat sheet with one point per square of `spacing` mm.
struct Sheet {
  float support_points = 0;
  PrintLength epsilon;
  PrintLength noise{kNoise};
};
Sheet sheet(double spacing, float support_points) {
  const double epsilon = spacing * std::sqrt(2.0 * kMinPts / std::numbers::pi);
  return {support_points, {static_cast<float>(epsilon)}};
}

FeatureLimits limits_of(const Sheet& found, const PrintGrid& grid) {
  return feature_limits(found.support_points, found.epsilon, found.noise, grid);
}

TEST(FeatureLimits, ARegionIsSmallUpToTheAreaOfASupportRadius) {
  const PrintGrid grid{.pitch_x_mm = 0.05F, .pitch_y_mm = 0.04F};
  constexpr double kSpacing = 0.2;
  const double pixels_a_point = kSpacing * kSpacing / (0.05 * 0.04);
  for (const float support : {40.0F, 60.0F, 100.0F}) {
    const FeatureLimits limits = limits_of(sheet(kSpacing, support), grid);
    EXPECT_NEAR(limits.pixels, static_cast<double>(support) * pixels_a_point, 1) << support;
    // A square with side epsilon has 60 / pi points, whatever the support radius.
    EXPECT_NEAR(limits.narrow_pixels, 60 / std::numbers::pi * pixels_a_point, 1) << support;
  }
}

TEST(FeatureLimits, AFlatFeatureIsAsHighAsNoiseMakesASurfaceUneven) {
  const auto layers = [&](float support, float layer_height) {
    return limits_of(sheet(0.2, support), {.layer_height_mm = layer_height}).flat_layers;
  };
  // The mean of 81 points with 0.09 mm of noise has 0.01 mm of noise: heights differ by 0.06 mm (+-3 deviations).
  EXPECT_EQ(layers(81, 0.05F), 3U);
  EXPECT_EQ(layers(81, 0.025F), 4U);
  EXPECT_EQ(layers(81, 0.1F), 2U);
  EXPECT_EQ(layers(16, 0.05F), 4U);
}

TEST(FeatureLimits, NoiseAllowsFeaturesOfMoreVoxels) {
  const PrintGrid grid;
  const auto voxels = [&](float support) { return static_cast<double>(limits_of(sheet(0.2, support), grid).voxels); };
  EXPECT_NEAR(voxels(4 * kCleanSupport), 4 * voxels(kCleanSupport), 4);
  EXPECT_GT(voxels(kCleanSupport), 0);
}

TEST(FeatureLimits, ANarrowFeatureIsAtMostTwoThirdsOfEpsilonHighWithoutNoise) {
  const PrintGrid grid{.layers = 800, .layer_height_mm = 0.05F};
  const auto limits = [&](float widened, float noise) {
    Sheet found = sheet(0.1, widened * kCleanSupport);
    found.epsilon = {0.47F};
    found.noise = {noise};
    return limits_of(found, grid);
  };
  EXPECT_EQ(limits(1, 0).narrow_layers, 7U);  // 0.313 mm
  EXPECT_GE(limits(1.2F, 0).narrow_layers, grid.layers) << "a stray cuts a shaft through all of the object";
  // A narrow feature may be at least as high as a flat one.
  EXPECT_EQ(limits(1, 1).narrow_layers, limits(1, 1).flat_layers);
}

TEST(FeatureLimits, ALooseFeatureMayBeAsLargeAsASmallComponent) {
  const PrintGrid grid{.pitch_x_mm = 0.05F, .pitch_y_mm = 0.04F, .layer_height_mm = 0.1F};
  Sheet found = sheet(0.1, kCleanSupport);
  found.epsilon = {0.5F};
  for (const float widened : {1.0F, 4.0F}) {
    found.support_points = widened * kCleanSupport;
    EXPECT_NEAR(static_cast<double>(limits_of(found, grid).loose_voxels), 31250, 1);  // 6.25 mm3
    EXPECT_EQ(limits_of(found, grid).loose_voxels, component_limits(found.epsilon, grid).min_voxels);
  }
}

}  // namespace
}  // namespace plumbline
