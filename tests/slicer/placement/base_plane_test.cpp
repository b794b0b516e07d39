#include "slicer/placement/base_plane.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace plumbline {
namespace {

constexpr float kLayer = 0.05F;

/// Walls of a cylinder of 10 mm radius and 20 mm height that stands at `height`.
std::vector<Vec3f> cylinder(std::size_t count, float height, float noise) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::normal_distribution<float> error(0, 1);
  std::vector<Vec3f> points;
  for (std::size_t i = 0; i < count; ++i) {
    const float angle = 6.2831853F * uniform(engine);
    points.emplace_back(10 * std::cos(angle), 10 * std::sin(angle), height + 20 * uniform(engine));
    if (noise > 0) points.back()[2] += noise * error(engine);
  }
  return points;
}

TEST(BasePlane, IsWhereWallsEndDespiteNoise) {
  for (const float noise : {0.0F, 0.01F, 0.03F, 0.05F}) {
    EXPECT_NEAR(base_plane(cylinder(100'000, 3, noise), kLayer), 3, 0.02) << "noise " << noise << " mm";
  }
}

TEST(BasePlane, IsNotMovedByADozenOutliers) {
  auto points = cylinder(100'000, 3, 0.03F);
  for (int i = 0; i < 12; ++i) points.emplace_back(0.0F, 0.0F, 0.1F * static_cast<float>(i));
  EXPECT_NEAR(base_plane(points, kLayer), 3, 0.012);
}

// Flying pixels up to half a millimetre below a rim once moved the plane down to the lowest of them.
TEST(BasePlane, IsNotMovedByATailOfOutliersBelowTheRim) {
  auto points = cylinder(100'000, 3, 0.03F);
  std::mt19937 engine(8);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < 150; ++i) points.emplace_back(10.0F, 0.0F, 3 - 0.5F * uniform(engine));
  EXPECT_NEAR(base_plane(points, kLayer), 3, 0.012);
}

TEST(BasePlane, IsWhereSmallFeetEnd) {
  auto points = cylinder(100'000, 3, 0.01F);
  std::mt19937 engine(9);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < 600; ++i) {  // feet with a fifth of the object's outline, 0.5 mm tall
    points.emplace_back(10.0F, uniform(engine), 2.5F + 0.5F * uniform(engine));
  }
  EXPECT_NEAR(base_plane(points, kLayer), 2.5, 0.06);
}

TEST(BasePlane, IsTheUndersideWhereItWasScanned) {
  auto points = cylinder(100'000, 3, 0.03F);
  std::mt19937 engine(6);
  std::uniform_real_distribution<float> uniform(-7, 7);
  std::normal_distribution<float> error(0, 0.03F);
  for (int i = 0; i < 30'000; ++i) points.emplace_back(uniform(engine), uniform(engine), 3 + error(engine));
  EXPECT_NEAR(base_plane(points, kLayer), 3, 0.11) << "where the noise of the underside begins";
}

TEST(BasePlane, TouchesATip) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<Vec3f> points;
  for (int i = 0; i < 100'000; ++i) {
    const float z = 20 * std::sqrt(uniform(engine));  // even density on a cone
    const float angle = 6.2831853F * uniform(engine);
    points.emplace_back(z * std::cos(angle), z * std::sin(angle), 2 + z);
  }
  EXPECT_NEAR(base_plane(points, kLayer), 2, 0.3);
  auto lowest = points[0][2];
  int below = 0;
  for (const auto& p : points) lowest = std::min(lowest, p[2]);
  const float base = base_plane(points, kLayer);
  for (const auto& p : points) below += p[2] < base ? 1 : 0;
  EXPECT_GE(base, lowest);
  EXPECT_LE(below, 12);
}

TEST(BasePlane, OfFewPointsIsTheLowestAfterADozen) {
  std::vector<Vec3f> points;
  points.reserve(100);
  for (int i = 0; i < 100; ++i) points.emplace_back(0.0F, 0.0F, 0.01F * static_cast<float>(i));
  EXPECT_FLOAT_EQ(base_plane(points, kLayer), 0.12F);
  EXPECT_FLOAT_EQ(base_plane(std::span(points).first(3), kLayer), 0.02F) << "the highest of fewer than a dozen";
}

}  // namespace
}  // namespace plumbline
