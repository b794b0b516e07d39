#include "slicer/cloud/filled_volume.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {
namespace filled_volume_test {

PointSpread spread_of(const Surface& points) {
  ArenaBlock arena(16 * kMiB);
  Cloud cloud = cloud_of(points, *arena);
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  return point_spread(cloud, tree);
}

Surface filled(std::uint32_t points, const Vec3d& size, bool is_ball) {
  Random random(points);
  Surface out;
  while (out.size() < points) {
    const Vec3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    if (!is_ball || p.norm() < 1) out.push_back({p.cwiseProduct(size), Vec3d::Zero()});
  }
  return out;
}

Surface lattice(int points_a_side, double step_z, double noise) {
  Random random(3);
  Surface out;
  for (int x = 0; x < points_a_side; ++x) {
    for (int y = 0; y < points_a_side; ++y) {
      for (int z = 0; z < points_a_side; ++z)
        out.push_back({Vec3d(x, y, step_z * z) + noise * random.vector(), Vec3d::Zero()});
    }
  }
  return out;
}

TEST(FilledVolume, IsSeenInBallsBoxesAndLattices) {
  EXPECT_TRUE(spread_of(filled(6'000, {1, 1, 1}, true)).fills_volume());
  EXPECT_TRUE(spread_of(filled(3'000, {1, 1, 1}, true)).fills_volume());
  for (const Vec3d& size : {Vec3d(1, 1, 1), Vec3d(1, 1, 0.3), Vec3d(1, 0.3, 0.3)}) {
    for (const bool is_ball : {false, true}) EXPECT_TRUE(spread_of(filled(20'000, size, is_ball)).fills_volume());
  }
  for (const int side : {14, 20, 30}) {
    EXPECT_TRUE(spread_of(lattice(side, 1, 0)).fills_volume()) << side;
    EXPECT_TRUE(spread_of(lattice(side, 1, 0.3)).fills_volume()) << side;
  }
}

TEST(FilledVolume, IsNotSeenInNoisySurfaces) {
  for (const std::uint32_t points : {3'000U, 20'000U}) {
    const double spacing = std::sqrt(4 * kPi / points);
    for (const double noise : {0.0, 1.0, 2.0, 3.0}) {
      Surface surface = sphere(points, 1, Vec3d::Zero());
      Random random(7);
      for (SurfacePoint& p : surface) p.position += noise * spacing * random.vector();
      EXPECT_FALSE(spread_of(surface).fills_volume()) << points << ' ' << noise;
    }
  }
}

TEST(FilledVolume, IsNotSeenInStoreys) {
  for (const int apart : {5, 6, 8, 10}) {
    Surface surface;
    for (int x = 0; x < 40; ++x) {
      for (int y = 0; y < 40; ++y) {
        for (int z = 0; z < 10; ++z) surface.push_back({Vec3d(x, y, z * apart), Vec3d::Zero()});
      }
    }
    EXPECT_FALSE(spread_of(surface).fills_volume()) << apart;
  }
}

TEST(FilledVolume, OfFewPointsOrPointsInOnePlaceIsNone) {
  EXPECT_FALSE(spread_of(Surface(3, SurfacePoint{Vec3d(1, 2, 3), Vec3d::Zero()})).fills_volume());
  EXPECT_FALSE(spread_of(Surface(100, SurfacePoint{Vec3d(1, 2, 3), Vec3d::Zero()})).fills_volume());
}

}  // namespace filled_volume_test
}  // namespace plumbline::testing
