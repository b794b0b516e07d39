#include "slicer/surface/joined_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace joined_points_test {

using namespace testing;

constexpr double kSpacing = 0.1;  ///< mm
constexpr float kRadius = 1.07F;  ///< mm

Cloud sorted_cloud(const Surface& surface, Arena& arena) {
  Cloud cloud = cloud_of(surface, arena, kRadius);
  const ArenaScope scope(arena);
  sort_by_tree(cloud, arena);
  return cloud;
}

std::uint32_t weight_of(const Cloud& cloud) {
  std::uint32_t sum = 0;
  for (const PackedNormal& n : cloud.normal.first(cloud.size)) sum += n.weight;
  return sum;
}

TEST(JoinedPoints, LieOnTheCurvedSurfaceOfTheirPoints) {
  ArenaBlock arena(16 * kMiB);
  const std::uint32_t points = sphere_points(3, kSpacing);
  Cloud cloud = sorted_cloud(sphere(points, 3, {0, 0, 0}), *arena);
  join_points(cloud);
  EXPECT_LT(cloud.size, points / 3);
  EXPECT_EQ(weight_of(cloud), points);
  double off = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    const Vec3d p = cloud.position[i].cast<double>();
    off += p.norm() - 3;
    EXPECT_GT(cloud.normal[i].unpack().cast<double>().dot(p / p.norm()), 0.999);
    EXPECT_FLOAT_EQ(cloud.radius[i], kRadius);
  }
  // Without the last term of the formula they would lie 1 micrometre inside.
  EXPECT_NEAR(off / cloud.size, 0, 2e-4);
}

TEST(JoinedPoints, DoNotJoinTheTwoSidesOfAThinWall) {
  ArenaBlock arena(16 * kMiB);
  Random random(1);
  Cloud cloud = sorted_cloud(box({0, 0, 0}, {6, 6, 0.02}, kSpacing, 0.3, random), *arena);
  join_points(cloud);
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    const Vec3f n = cloud.normal[i].unpack();
    if (std::abs(n[2]) < 0.5F) continue;
    EXPECT_GT(std::abs(n[2]), 0.999F);
    EXPECT_NEAR(cloud.position[i][2], n[2] > 0 ? 0.02F : 0.0F, 1e-4F);
  }
}

TEST(JoinedPoints, KeepTheMeanOfNoisyPoints) {
  ArenaBlock arena(16 * kMiB);
  Random random(2);
  Surface surface = sheet({0, 0, 0}, {10, 0, 0}, {0, 10, 0}, kSpacing, 0.3, random);
  add_noise(surface, 0.05, 0.1, random);
  double mean = 0;
  for (const SurfacePoint& p : surface) mean += p.position[2] / static_cast<double>(surface.size());
  Cloud cloud = sorted_cloud(surface, *arena);
  join_points(cloud);
  double joined = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    joined += static_cast<double>(cloud.position[i][2]) * cloud.normal[i].weight / static_cast<double>(surface.size());
  }
  EXPECT_NEAR(joined, mean, 1e-3);
}

TEST(JoinedPoints, AreAsFewAsThereIsRoomFor) {
  ArenaBlock arena(16 * kMiB);
  const std::uint32_t points = sphere_points(3, kSpacing);
  Cloud cloud = sorted_cloud(sphere(points, 3, {0, 0, 0}), *arena);
  join_points(cloud, points / 12);
  EXPECT_LE(cloud.size, points / 12);
  EXPECT_GT(cloud.size, points / 16) << "and hardly fewer";
  EXPECT_EQ(weight_of(cloud), points);
  for (std::uint32_t i = 0; i < cloud.size; ++i) EXPECT_NEAR(cloud.position[i].norm(), 3, 0.005F);
}

}  // namespace joined_points_test
}  // namespace plumbline
