#include "slicer/surface/bores/cylinder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "slicer/core/numbers/vec.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(Frame, IsPerpendicularToItsDirection) {
  for (const Vec3f& direction : {Vec3f(1, 0, 0), Vec3f(0, -1, 0), Vec3f(0, 0, 1), Vec3f(1, 1, 1), Vec3f(-3, 2, 0.1F)}) {
    const Vec3f n = direction / std::sqrt(direction.dot(direction));
    const Frame frame(n);
    EXPECT_NEAR(frame.t.dot(frame.t), 1, 1e-5);
    EXPECT_NEAR(frame.t.dot(n), 0, 1e-6);
    EXPECT_NEAR((n.cross(frame.t) - frame.s).dot(frame.s), 0, 1e-6);
    EXPECT_NEAR(frame.at(0.6F, 0.8F).dot(frame.s), 0.8, 1e-5);
  }
}

TEST(Cylinder, HasCoordinatesAlongAndAroundItsAxis) {
  const Cylinder lying{{1, 2, 3}, Vec3f::UnitX(), 2};
  const OnCylinder seen = cylinder_coordinates(lying, {5, 2, 0});
  EXPECT_FLOAT_EQ(seen.along, 4);
  EXPECT_FLOAT_EQ(seen.distance, 3);
  EXPECT_FLOAT_EQ(seen.outwards[2], -1);
  EXPECT_FLOAT_EQ(cylinder_coordinates(lying, lying.on_axis(7)).distance, 0);
}

/// Points of a third of a cylinder's wall, up to 0.05 mm off it.
std::vector<Vec3f> wall(const Cylinder& cylinder) {
  Random random(1);
  const Frame frame(cylinder.axis);
  std::vector<Vec3f> points;
  for (int k = 0; k < 300; ++k) {
    const double angle = random.uniform(0, 2 * kPi / 3);
    const auto distance = static_cast<float>(static_cast<double>(cylinder.radius) + random.uniform(-0.05, 0.05));
    const Vec3f outwards = frame.at(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
    points.emplace_back(cylinder.on_axis(static_cast<float>(random.uniform(-4, 4))) + outwards * distance);
  }
  return points;
}

TEST(Cylinder, IsFittedToAThirdOfItsWall) {
  const Vec3f axis = Vec3f(1, 2, 6) / std::sqrt(41.0F);
  const Cylinder truth{{10, -4, 2}, axis, 1.5F};
  const std::vector<Vec3f> points = wall(truth);
  const Vec3f tilted = axis + Vec3f(0.15F, -0.1F, 0);
  Cylinder found{{10.3F, -4.2F, 2}, tilted / std::sqrt(tilted.dot(tilted)), 1.2F};
  for (int k = 0; k < 8; ++k) {
    CylinderFit fit(found);
    for (const Vec3f& p : points) fit.add(cylinder_coordinates(found, p), 1);
    ASSERT_TRUE(fit.improve(found));
  }
  EXPECT_NEAR(found.radius, truth.radius, 0.01) << "mm";
  EXPECT_GT(found.axis.dot(axis), std::cos(0.2 * kPi / 180)) << "within 0.2 degrees";
  EXPECT_LT(cylinder_coordinates(truth, found.middle).distance, 0.01) << "mm";
}

TEST(Cylinder, KeepsWhatThePointsDontDetermine) {
  Cylinder alone{{1, 2, 3}, Vec3f::UnitZ(), 1};
  EXPECT_FALSE(CylinderFit(alone).improve(alone));
  // One point determines where the wall is on its side, but not the direction of the axis.
  CylinderFit fit(alone);
  fit.add(cylinder_coordinates(alone, {2.1F, 2, 3}), 1);
  ASSERT_TRUE(fit.improve(alone));
  EXPECT_FLOAT_EQ(alone.axis[2], 1);
  EXPECT_NEAR(cylinder_coordinates(alone, {2.1F, 2, 3}).distance, alone.radius, 1e-3);
  EXPECT_FALSE([&] {
    CylinderFit far(alone);
    far.add(cylinder_coordinates(alone, {50, 2, 3}), 1);
    return far.improve(alone);
  }()) << "a step of many diameters is refused";
}

}  // namespace
}  // namespace plumbline
