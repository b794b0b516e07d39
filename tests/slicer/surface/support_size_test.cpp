#include "slicer/surface/support_size.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/stop.hpp"

namespace plumbline {
namespace support_size_test {

using namespace testing;

constexpr double kSpacing = 0.15;  ///< mm
constexpr int kRows = 134;         ///< rows of points, and points in a row

/// A square of 20 mm with waves of the given amplitude and length, scanned with noise.
Surface waves(double height, double length, double noise, Random& random) {
  Surface surface;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kRows; ++column) {
      const double at = (column + random.uniform(-0.5, 0.5)) * kSpacing;
      const double phase = 2 * kPi * at / length;
      const double z = height * std::sin(phase) + noise * random.normal();
      const double slope = height * 2 * kPi / length * std::cos(phase);
      surface.push_back({Vec3d(at, (row + random.uniform(-0.5, 0.5)) * kSpacing, z), Vec3d(-slope, 0, 1).normalized()});
    }
  }
  return surface;
}

struct Widened {
  ArenaBlock block{32 * kMiB};
  float support_before = 0;
  float support_after = 0;
  float growth = 1;       ///< of all radii
  std::size_t taken = 0;  ///< bytes of arena

  /// @param marked  points above this height are marked as noise before the supports are widened
  explicit Widened(const Surface& surface, float marked = 1e9F) {
    Arena& arena = *block;
    Cloud cloud = cloud_of(surface, arena);
    const KdTree3 tree = sort_by_tree(cloud, arena);
    const float epsilon = value_of(density_epsilon(cloud, tree, arena));
    value_of(cluster(cloud, tree, epsilon, arena));
    for (std::uint32_t i = 0; i < cloud.size; ++i) {
      if (cloud.position[i][2] > marked) cloud.normal[i].point_class = PointClass::kNoise;
    }
    support_before = cloud.support_points;
    const float radius = cloud.radius[0];
    const std::size_t used = arena.used();
    arena.reset_peak();
    EXPECT_TRUE(widen_supports(cloud, tree, arena));
    support_after = cloud.support_points;
    taken = arena.peak() - used;
    EXPECT_EQ(arena.used(), used);
    growth = cloud.radius[0] / radius;
  }
};

TEST(SupportSize, WidensSupportsOfASmoothNoisySurface) {
  Random random(1);
  const Widened smooth(waves(1, 20, 0.03, random));
  EXPECT_GT(smooth.support_before, 20);
  EXPECT_GT(smooth.support_after, 1.5F * smooth.support_before);
  EXPECT_NEAR(smooth.growth, std::sqrt(smooth.support_after / smooth.support_before), 1e-4);
  EXPECT_GT(smooth.taken, 0U);
  EXPECT_LE(smooth.taken, support_size_bytes(static_cast<std::uint32_t>(omp_get_max_threads())));
}

TEST(SupportSize, IsTheSameForAnyNumberOfThreads) {
  const int usual = omp_get_max_threads();
  std::vector<float> growths;
  for (const int threads : {1, 3}) {
    omp_set_num_threads(threads);
    Random random(1);
    const Widened widened(waves(1, 20, 0.03, random));
    EXPECT_LE(widened.taken, support_size_bytes(static_cast<std::uint32_t>(threads)));
    growths.push_back(widened.growth);
  }
  omp_set_num_threads(usual);
  EXPECT_GT(growths[0], 1);
  EXPECT_EQ(growths[0], growths[1]);
}

TEST(SupportSize, KeepsSupportsWhereDetailExceedsTheNoise) {
  Random random(2);
  const Widened detailed(waves(0.3, 1.5, 0.03, random));
  EXPECT_GT(detailed.support_before, 20);
  EXPECT_EQ(detailed.support_after, detailed.support_before);
  EXPECT_EQ(detailed.growth, 1);
}

TEST(SupportSize, KeepsSupportsOfAScanWithoutNoiseOrWithFewPoints) {
  Random random(3);
  EXPECT_EQ(Widened(waves(1, 20, 0.001, random)).growth, 1);
  Surface few = waves(1, 20, 0.03, random);
  few.resize(2000);
  EXPECT_EQ(Widened(few).growth, 1);
}

// A rougher surface above, marked as noise, does not count.
TEST(SupportSize, IgnoresPointsMarkedAsNoise) {
  Random random(4);
  Surface scan = waves(1, 20, 0.03, random);
  for (SurfacePoint rough : waves(0.3, 2, 0.03, random)) {
    rough.position[2] += 10;
    scan.push_back(rough);
  }
  EXPECT_GT(Widened(scan, 5).growth, 1.1F * Widened(scan).growth);
}

TEST(SupportSize, ReportsProgressAndStopsWhenCancelled) {
  StopAtThird stop;
  Random random(5);
  ArenaBlock block(32 * kMiB);
  Arena& arena = *block;
  Cloud cloud = cloud_of(waves(1, 20, 0.03, random), arena);
  const KdTree3 tree = sort_by_tree(cloud, arena);
  const float epsilon = value_of(density_epsilon(cloud, tree, arena));
  value_of(cluster(cloud, tree, epsilon, arena));
  const float before = cloud.radius[0];
  const Status status = widen_supports(cloud, tree, arena, {&stop, Stage::kClustering});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code(), ErrorCode::kCancelled);
  EXPECT_EQ(stop.reports, 3);
  EXPECT_EQ(cloud.radius[0], before);
}

}  // namespace support_size_test
}  // namespace plumbline
