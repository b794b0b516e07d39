/// Points scattered inside an object and around it, without normals: its volume is that without them.

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>

#include "slicer/cloud/outliers.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace scattered_points_test {

using namespace testing;

constexpr double kRadius = 10;
constexpr double kBall = 4.0 / 3 * kPi * kRadius * kRadius * kRadius;
constexpr std::uint32_t kPoints = 12000;

void scatter(Surface& surface, std::uint32_t points, double half_side, double within, Random& random) {
  for (std::uint32_t i = 0; i < points;) {
    const Vec3d at(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    if (half_side * std::sqrt(at.squaredNorm()) > within) continue;
    surface.push_back({half_side * at, random.vector().normalized()});
    ++i;
  }
}

double volume_of(Surface surface, bool with_normals, Random& random) {
  shuffle(surface, random);
  for (SurfacePoint& p : surface) {
    if (!with_normals) p.normal.setZero();
  }
  return Slicing(binary_ply(surface), settings_with_pitch(0.4F), 64 * kMiB).volume();
}

TEST(ScatteredPoints, DontChangeTheVolume) {
  for (const bool with_normals : {false, true}) {
    for (const double share : {0.0, 0.02, 0.2}) {
      Random random(3);
      Surface surface = sphere(kPoints, kRadius, {0, 0, 0});
      scatter(surface, static_cast<std::uint32_t>(share * kPoints), kRadius, 0.98 * kRadius, random);
      EXPECT_NEAR(volume_of(surface, with_normals, random) / kBall, 1, 0.005) << share << " inside, " << with_normals;
    }
    Random random(4);
    Surface surface = sphere(kPoints, kRadius, {0, 0, 0});
    scatter(surface, kPoints * 3 / 10, 1.4 * kRadius, 100, random);
    EXPECT_NEAR(volume_of(surface, with_normals, random) / kBall, 1, 0.005) << "around, " << with_normals;
  }
}

/// Half of a sphere with a share of the points of the other half.
Surface half_sparse(std::uint32_t one_in) {
  Surface surface;
  std::uint32_t number = 0;
  for (const SurfacePoint& p : sphere(kPoints, kRadius, {0, 0, 0})) {
    if (p.position[0] > 0 || number++ % one_in == 0) surface.push_back(p);
  }
  return surface;
}

TEST(ScatteredPoints, AreNotTheSparseHalfOfASphere) {
  for (const std::uint32_t one_in : {5U, 20U}) {
    Surface surface = half_sparse(one_in);
    for (SurfacePoint& p : surface) p.normal.setZero();
    ArenaBlock arena(16 * kMiB);
    Cloud cloud = cloud_of(surface, *arena);
    const KdTree3 tree = sort_by_tree(cloud, *arena);
    EXPECT_EQ(value_of(drop_outliers(cloud, tree, *arena)), 0U) << one_in;
  }
}

// The nearest points of a sparse one inside a tube are those of its outside, on whose plane it does not lie.
TEST(ScatteredPoints, AreNotTheSparseSideOfAThinWall) {
  Random random(6);
  Surface surface = sheet({-8, -8, 0}, {0, 16, 0}, {16, 0, 0}, 0.14, 0.3, random);
  append(surface, sheet({-8, -8, 0.8}, {16, 0, 0}, {0, 16, 0}, 0.7, 0.3, random));
  for (SurfacePoint& p : surface) p.normal.setZero();
  ArenaBlock arena(16 * kMiB);
  Cloud cloud = cloud_of(surface, *arena);
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  EXPECT_EQ(value_of(drop_outliers(cloud, tree, *arena)), 0U);
}

// Sparse points are asked among each other. So few make no sheet.
TEST(ScatteredPoints, AreFoundIfTheyAreFew) {
  Random random(8);
  Surface surface = sphere(800, kRadius, {0, 0, 0});
  scatter(surface, 12, 3 * kRadius, 100, random);
  for (SurfacePoint& p : surface) p.normal.setZero();
  ArenaBlock arena(16 * kMiB);
  Cloud cloud = cloud_of(surface, *arena);
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  EXPECT_GT(value_of(drop_outliers(cloud, tree, *arena)), 8U);
}

TEST(ScatteredPoints, LeaveTheSparseHalfOfASphere) {
  Random random(5);
  Surface surface = half_sparse(5);
  scatter(surface, kPoints / 20, 1.2 * kRadius, 100, random);
  EXPECT_NEAR(volume_of(surface, false, random) / kBall, 1, 0.005);
}

}  // namespace scattered_points_test
}  // namespace plumbline
