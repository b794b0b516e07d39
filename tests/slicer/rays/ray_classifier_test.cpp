#include "slicer/rays/ray_classifier.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kSpacing = 0.25;  ///< mm
constexpr float kRadius = 1.2F;    ///< mm
constexpr float kPointsInReach = static_cast<float>(kPi) * kRadius * kRadius / static_cast<float>(kSpacing * kSpacing);

/// The crossings of the ray through (10, 10), mm.
std::vector<float> crossings(const Surface& surface) {
  ArenaBlock block(16 * kMiB);
  Arena& arena = *block;
  Cloud cloud = cloud_of(surface, arena, kRadius);
  cloud.support_points = kPointsInReach;
  std::vector<WindingTree::Node> nodes(WindingTree::nodes_needed(cloud.size));
  const WindingTree winding = WindingTree::build(cloud, nodes);
  const KdTree2 tree = value_of(KdTree2::build(cloud.positions(), arena, "test"));
  PrintGrid grid;
  grid.columns = grid.rows = 100;
  grid.layers = 200;
  grid.pitch_x_mm = grid.pitch_y_mm = 0.2F;
  RayClassifierSettings settings;
  settings.intersections.width = 0.3F;
  RayClassifier classifier =
      value_of(RayClassifier::create(cloud, tree, winding, grid, kRadius, cloud.size, settings, arena));
  classifier.begin_tile(48, 48);
  std::vector<float> depths;
  for (const RayCrossing& crossing : classifier.ray(50, 50).crossings) depths.push_back(crossing.depth);
  return depths;
}

/// A plate of 20 x 20 x 1 mm, its sides left out.
Surface plate(Random& random) {
  Surface surface = sheet({0, 0, 5}, {0, 20, 0}, {20, 0, 0}, kSpacing, 0.2, random);
  append(surface, sheet({0, 0, 6}, {20, 0, 0}, {0, 20, 0}, kSpacing, 0.2, random));
  return surface;
}

void expect_the_plate(const Surface& surface, float tolerance) {
  const std::vector<float> found = crossings(surface);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0], 5, tolerance);
  EXPECT_NEAR(found[1], 6, tolerance);
}

TEST(RayClassifier, EntersAndExitsAPlate) {
  Random random(1);
  expect_the_plate(plate(random), 0.05F);
}

// Wide supports beyond an edge once made a ray inside out at both ends, and all of it was left out: a shaft through the
// object.
TEST(RayClassifier, KeepsTheSolidBetweenTwoFalseSheets) {
  Random random(2);
  Surface surface = plate(random);
  append(surface, sheet({9, 9, 4.2}, {2, 0, 0}, {0, 2, 0}, kSpacing, 0.2, random));
  append(surface, sheet({9, 9, 6.8}, {0, 2, 0}, {2, 0, 0}, kSpacing, 0.2, random));
  expect_the_plate(surface, 0.3F);
}

// Noise tilts the planes that go on beyond an edge; they met below the rims of walls, and a print began with what hung there.
TEST(RayClassifier, MissesASheetThatEndsBesideTheRay) {
  Random random(3);
  Surface surface = plate(random);
  append(surface, sheet({8.4, 9, 8.3}, {0, 2, 0}, {1, 0, 0}, kSpacing, 0.2, random));
  append(surface, sheet({8.4, 9, 8.8}, {1, 0, 0}, {0, 2, 0}, kSpacing, 0.2, random));
  expect_the_plate(surface, 0.05F);
}

// Behind a one-sided sheet the winding number is a half at most, and what closes holes as round as their rims lean may take it
// for inside: background that stood across the object was printed as a thin solid.
TEST(RayClassifier, MakesNoSolidBehindASheetThatHangsInTheAir) {
  Random random(5);
  Surface surface = box({1, 1, 5}, {19, 19, 6}, kSpacing, 0.2, random);
  append(surface, sheet({2, 2, 12}, {16, 0, 0}, {0, 16, 0}, kSpacing, 0.2, random));
  expect_the_plate(surface, 0.05F);
}

/// A box from z = 3 to 8.5, the ray just behind the wall at x = 10.8, with a few points below that wall's rim.
/// @param gap  mm of the wall that were not seen
Surface box_with_points_below_its_rim(double gap) {
  Random random(4);
  const double x = 10.8;
  const double strip = 0.5 * (5.5 - gap);
  Surface surface = sheet({x, 2, 3}, {0, 16, 0}, {0, 0, strip}, kSpacing, 0.2, random);
  append(surface, sheet({x, 2, 8.5 - strip}, {0, 16, 0}, {0, 0, strip}, kSpacing, 0.2, random));
  append(surface, sheet({x - 8, 2, 3}, {0, 0, 5.5}, {0, 16, 0}, kSpacing, 0.2, random));
  append(surface, sheet({x - 8, 2, 3}, {8, 0, 0}, {0, 0, 5.5}, kSpacing, 0.2, random));
  append(surface, sheet({x - 8, 18, 3}, {0, 0, 5.5}, {8, 0, 0}, kSpacing, 0.2, random));
  append(surface, sheet({x - 8, 2, 3}, {0, 16, 0}, {5.5, 0, 0}, kSpacing, 0.2, random));
  append(surface, sheet({x - 8, 2, 8.5}, {8, 0, 0}, {0, 16, 0}, kSpacing, 0.2, random));
  append(surface, sheet({x, 9.4, 1.4}, {0, 1.2, 0}, {0, 0, 1.6}, kSpacing, 0.2, random));
  return surface;
}

// Points below the rim make a band that is inside from 0.56 mm on. Without a sheet the object once began there; with one, the
// top, that was left out, and all that is behind the wall with it.
TEST(RayClassifier, BeginsWithTheObjectBehindAWallThatContinuesBelowIt) {
  for (const double gap : {3.5, 0.0}) {
    const std::vector<float> found = crossings(box_with_points_below_its_rim(gap));
    ASSERT_EQ(found.size(), 2U) << gap;
    EXPECT_GT(found[0], 1.4) << gap;
    EXPECT_LT(found[0], 3.1) << gap;
    EXPECT_NEAR(found[1], 8.5, 0.1F) << gap;
  }
}

}  // namespace
}  // namespace plumbline
