#include "slicer/rays/ray_classifier.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace ray_classifier_test {

using namespace testing;

constexpr double kSpacing = 0.25;  ///< mm
constexpr float kRadius = 1.2F;    ///< mm
constexpr float kPointsInReach = static_cast<float>(kPi) * kRadius * kRadius / static_cast<float>(kSpacing * kSpacing);

/// The crossings of the ray through (10, 10), mm.
std::vector<float> crossings(const Surface& surface, std::uint32_t layers = 200) {
  ArenaBlock block(32 * kMiB);
  Arena& arena = *block;
  Cloud cloud = cloud_of(surface, arena, kRadius);
  sort_by_tree(cloud, arena);
  cloud.support_points = kPointsInReach;
  std::vector<WindingTree::Node> nodes(WindingTree::nodes_needed(cloud.size));
  const WindingTree winding = WindingTree::build(cloud, nodes);
  const KdTree2 tree = value_of(KdTree2::build(cloud.positions(), arena, "test"));
  PrintGrid grid;
  grid.columns = grid.rows = 100;
  grid.layers = layers;
  grid.pitch_x_mm = grid.pitch_y_mm = 0.2F;
  const RayField field{.cloud = &cloud,
                       .tree = &tree,
                       .winding = &winding,
                       .grid = grid,
                       .width = 0.3F,
                       .widths = {kRadius},
                       .tile_capacity = cloud.size};
  RayClassifier classifier = value_of(RayClassifier::create(field, arena));
  classifier.begin_tile(48, 48);
  std::vector<float> depths;
  for (const RayCrossing& crossing : classifier.ray(50, 50).crossings) depths.push_back(crossing.depth);
  return depths;
}

/// A plate of 20 x 20 x 1 mm without its sides.
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

// Through a tall lattice. Were the lowest kept, it would lose its top.
TEST(RayClassifier, DropsTheThinnestStretchesOfARayWithTooManyCrossings) {
  constexpr int kPlates = 130;
  Random random(3);
  Surface surface;
  for (int k = 0; k < kPlates; ++k) {
    const double low = 2 + 2.5 * k;
    const double high = low + (k == 0 || k + 1 == kPlates ? 1.3 : 1);
    append(surface, sheet({8, 8, low}, {0, 4, 0}, {4, 0, 0}, kSpacing, 0.2, random));
    append(surface, sheet({8, 8, high}, {4, 0, 0}, {0, 4, 0}, kSpacing, 0.2, random));
  }
  const std::vector<float> found = crossings(surface, 7000);
  ASSERT_EQ(found.size(), RayClassifier::kMaxCrossings);
  EXPECT_NEAR(found.front(), 2, 0.1);
  EXPECT_NEAR(found.back(), 2 + 2.5 * (kPlates - 1) + 1.3, 0.1);
}

// Wide support radii beyond an edge once turned a ray inside out at both ends. The whole ray was dropped, which left a
// shaft through the object.
TEST(RayClassifier, KeepsTheSolidBetweenTwoFalseSheets) {
  Random random(2);
  Surface surface = plate(random);
  append(surface, sheet({9, 9, 4.2}, {2, 0, 0}, {0, 2, 0}, kSpacing, 0.2, random));
  append(surface, sheet({9, 9, 6.8}, {0, 2, 0}, {2, 0, 0}, kSpacing, 0.2, random));
  expect_the_plate(surface, 0.3F);
}

// Noise tilts the planes that MLS continues beyond an edge. Below the rims of walls such planes once met, and the print
// began with the solid between them.
TEST(RayClassifier, MissesASheetThatEndsBesideTheRay) {
  Random random(3);
  Surface surface = plate(random);
  append(surface, sheet({8.4, 9, 8.3}, {0, 2, 0}, {1, 0, 0}, kSpacing, 0.2, random));
  append(surface, sheet({8.4, 9, 8.8}, {1, 0, 0}, {0, 2, 0}, kSpacing, 0.2, random));
  expect_the_plate(surface, 0.05F);
}

// Behind a one-sided sheet the winding number is at most 1/2, but the correction for curved rims of holes can make it
// count as inside. So scanned background across the object was once printed as a thin solid.
TEST(RayClassifier, MakesNoSolidBehindASheetThatHangsInTheAir) {
  Random random(5);
  Surface surface = box({1, 1, 5}, {19, 19, 6}, kSpacing, 0.2, random);
  // Behind a sheet 14 mm wide the lean of its rim makes solid, see WindingTree::inside().
  append(surface, sheet({5, 5, 12}, {10, 0, 0}, {0, 10, 0}, kSpacing, 0.2, random));
  expect_the_plate(surface, 0.05F);
}

/// A box from z = 3 to 8.5 with a few points below the rim of its wall at x = 10.8. The ray passes just behind it.
/// @param gap  height of the unseen strip of that wall, mm
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

// Points below the rim make a band that is inside from 0.56 mm on. If the band had no sheet, the object once began
// there. If it had one, the top, that sheet was dropped, and with it the solid behind the wall.
TEST(RayClassifier, BeginsWithTheObjectBehindAWallThatContinuesBelowIt) {
  for (const double gap : {3.5, 0.0}) {
    const std::vector<float> found = crossings(box_with_points_below_its_rim(gap));
    ASSERT_EQ(found.size(), 2U) << gap;
    EXPECT_GT(found[0], 1.4) << gap;
    EXPECT_LT(found[0], 3.1) << gap;
    EXPECT_NEAR(found[1], 8.5, 0.1F) << gap;
  }
}

}  // namespace ray_classifier_test
}  // namespace plumbline
