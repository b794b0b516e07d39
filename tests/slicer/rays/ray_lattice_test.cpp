#include "slicer/rays/ray_lattice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr float kPitch = 0.05F;      ///< mm
constexpr float kTolerance = 2e-3F;  ///< mm
constexpr std::uint32_t kRays = kTileSide * kTileSide;

/// Decides tiles of a grid of 400 x 400 rays in both ways: ray by ray, and with a lattice.
class LatticeLaboratory {
 public:
  /// @param spacing  of the surface's points, mm
  LatticeLaboratory(const Surface& surface, double spacing) {
    const float radius = 3 * static_cast<float>(spacing);
    cloud_ = cloud_of(surface, *arena_, radius);
    cloud_.support_points = static_cast<float>(kPi) * 9;
    nodes_.resize(WindingTree::nodes_needed(cloud_.size));
    winding_ = WindingTree::build(cloud_, nodes_);
    tree_ = value_of(KdTree2::build(cloud_.positions(), *arena_, "test"));
    PrintGrid grid;
    grid.columns = grid.rows = grid.layers = 400;
    grid.pitch_x_mm = grid.pitch_y_mm = grid.layer_height_mm = kPitch;
    const RayField field{.cloud = &cloud_,
                         .tree = &tree_,
                         .winding = &winding_,
                         .grid = grid,
                         .width = 2 * static_cast<float>(spacing),
                         .widths = {radius},
                         .tile_capacity = cloud_.size};
    classifier_ = value_of(RayClassifier::create(field, *arena_));
  }

  /// Decides the tile that begins at this pixel. Counts how its rays were decided, and compares them.
  void compare(std::uint32_t column, std::uint32_t row) {
    classifier_.begin_tile(column, row);
    lattice_.decide(classifier_, column, row);
    guided += lattice_.guided();
    interpolated += lattice_.interpolated();
    for (std::uint32_t i = 0; i < kRays; ++i) {
      const TileRay& ray = lattice_.ray(i % kTileSide, i / kTileSide);
      if (!ray.known) continue;
      ++known;
      const ClassifiedRay shot = classifier_.ray(column + i % kTileSide, row + i / kTileSide);
      ASSERT_EQ(ray.count, shot.crossings.size()) << column << " " << row << " " << i;
      // A ray without crossings is outside or away, as its corner is.
      ASSERT_TRUE(ray.count == 0 || ray.decision == shot.decision);
      for (std::uint32_t k = 0; k < ray.count; ++k) {
        worst = std::max(worst, std::abs(ray.crossing[k].depth - shot.crossings[k].depth));
      }
    }
  }

  void compare_row(std::uint32_t first_column, std::uint32_t end_column, std::uint32_t row) {
    for (std::uint32_t column = first_column; column < end_column; column += kTileSide) compare(column, row);
  }

  std::uint32_t known = 0;
  std::uint32_t guided = 0;
  std::uint32_t interpolated = 0;
  float worst = 0;  ///< distance of a crossing from where the shot ray has it, mm

 private:
  ArenaBlock arena_{64 * kMiB};
  Cloud cloud_;
  std::vector<WindingTree::Node> nodes_;
  WindingTree winding_;
  KdTree2 tree_;
  RayClassifier classifier_;
  RayLattice lattice_{kTolerance};
};

TEST(RayLattice, InterpolatesMostRaysOfASmoothSurface) {
  LatticeLaboratory laboratory(sphere(sphere_points(8, 0.15), 8, {10, 10, 10}), 0.15);
  laboratory.compare_row(120, 280, 200);
  EXPECT_EQ(laboratory.known, 20 * kRays);
  EXPECT_GT(laboratory.interpolated, 15 * kRays);
  EXPECT_LT(laboratory.worst, 2 * kTolerance);
}

// Sixteen tiles, the first four of which have nothing above them and every fourth nothing before it.
TEST(RayLattice, ShootsTheCornersThatTilesOfAColumnShareOnce) {
  LatticeLaboratory laboratory(sphere(sphere_points(8, 0.15), 8, {10, 10, 10}), 0.15);
  constexpr std::uint32_t kFirst = 6 * RayClassifier::kColumnSide;
  for (std::uint32_t row = kFirst; row < kFirst + RayClassifier::kColumnSide; row += kTileSide) {
    laboratory.compare_row(kFirst, kFirst + RayClassifier::kColumnSide, row);
  }
  EXPECT_EQ(laboratory.known, 16 * kRays);
  EXPECT_EQ(laboratory.known - laboratory.guided - laboratory.interpolated, 5 * 5);
  EXPECT_LT(laboratory.worst, 2 * kTolerance);
}

TEST(RayLattice, GuidesRaysWhereNoiseMakesTheSurfaceRough) {
  Random random(1);
  Surface surface = sphere(sphere_points(8, 0.15), 8, {10, 10, 10});
  add_noise(surface, 0.03, 0.1, random);
  LatticeLaboratory laboratory(surface, 0.15);
  laboratory.compare_row(120, 280, 200);
  EXPECT_GT(laboratory.guided, 5 * kRays);
  EXPECT_GT(laboratory.known, 15 * kRays);
  EXPECT_LT(laboratory.worst, 5 * kTolerance);
}

TEST(RayLattice, AgreesWithEveryRayAcrossTheEdgesOfABox) {
  Random random(2);
  LatticeLaboratory laboratory(box({5.03, 5.07, 5}, {15.01, 15.02, 9}, 0.15, 0.2, random), 0.15);
  laboratory.compare_row(80, 320, 200);
  EXPECT_GT(laboratory.known, 20 * kRays);
  EXPECT_LT(laboratory.worst, 2 * kTolerance);
}

// Only ray 1 of the tile along both axes meets the pin. None of the rays that are looked at first is within its supports.
TEST(RayLattice, MissesNoPinBetweenTheRaysThatItLooksAt) {
  constexpr double kSpacing = 0.01;
  Random random(3);
  Surface surface = box({9.5, 9.5, 5}, {10.9, 10.9, 6}, kSpacing, 0.2, random);
  append(surface, box({10.06, 10.06, 6}, {10.09, 10.09, 7}, kSpacing, 0.2, random));
  LatticeLaboratory laboratory(surface, kSpacing);
  laboratory.compare(200, 200);
  EXPECT_GT(laboratory.known, kRays / 2);
  EXPECT_LT(laboratory.worst, 2 * kTolerance);
}

// A ball without normals and with a hole below, and a line of points below it that puts a base plane near it. The base plane's
// crossing lay between two of the ball's, so that some pixels were twice in a layer.
TEST(RayLattice, KeepsTheCrossingsOfARayInOrder) {
  Surface scan;
  for (int i = 0; i < 129; ++i) {
    scan.push_back({Vec3d(10 - 0.7647 * i, -9.2157 + 0.0196 * i, -8.4314 + 0.0275 * i), {0, 0, 1}});
  }
  for (SurfacePoint p : sphere(1984, 8.8235, {0.0392, 0.0392, 0.0392})) {
    if (scan.size() == 2000) break;
    p.normal.setZero();
    scan.push_back(p);
  }
  const Slicing slicing(binary_ply(scan), settings_with_pitch(0.3F), 4 * kMiB);
  ASSERT_TRUE(slicing.report().flat_underside);
  const RRep& rrep = slicing.rrep();
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
    const auto crossings = rrep.packed.subspan(rrep.first[k], rrep.first[k + 1] - rrep.first[k]);
    const auto pixel = [&](std::uint32_t packed) { return CrossingPacking(rrep.grid).pixel(packed); };
    EXPECT_TRUE(std::ranges::adjacent_find(crossings, std::ranges::greater_equal{}, pixel) == crossings.end())
        << "a pixel is twice in layer " << k;
  }
}

}  // namespace
}  // namespace plumbline
