#include "slicer/cloud/nth_nearest.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// Asks for the k-th nearest of every point and of places between, with KdTree::nearest() as the oracle.
void expect_distances(std::vector<Vec3f> points) {
  ArenaBlock arena(4 * kMiB);
  KdTree3 tree = value_of(KdTree3::build(points, *arena, "test"));
  const std::vector<Vec3f> before = points;
  for (std::uint32_t i = 0; i < points.size(); ++i) points[i] = before[tree.order()[i]];
  tree.adopt_order();
  for (const std::uint32_t k : {1U, 2U, 61U, NthNearest::kMost}) {
    if (k > points.size()) continue;
    NthNearest nth(points, tree);
    std::vector<Neighbour> found(k);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const Vec3f query = i % 3 == 0 ? Vec3f((points[i] + points[0]) / 2) : points[i];
      ASSERT_EQ(tree.nearest(query, found), k);
      ASSERT_EQ(nth.distance2(query, k), found[k - 1].distance2) << "k " << k << ", point " << i;
    }
  }
}

TEST(NthNearest, GivesTheDistanceThatTheTreeGives) {
  Random random(11);
  std::vector<Vec3f> points(3000);
  for (Vec3f& p : points) {
    p = Vec3d(random.uniform(0, 30), random.uniform(0, 30), random.uniform(0, 1)).cast<float>();
  }
  expect_distances(points);
}

TEST(NthNearest, FindsItsWayFromDenseToSparse) {
  Random random(12);
  std::vector<Vec3f> points;
  for (int n = 0; n < 2000; ++n) {
    const double size = n % 4 == 0 ? 100 : 0.01;  // a few hundred points all over, the rest in one place
    points.push_back(Vec3d(random.uniform(0, size), random.uniform(0, size), random.uniform(0, size)).cast<float>());
  }
  expect_distances(points);
}

TEST(NthNearest, BearsEqualDistancesAndEqualPoints) {
  Random random(13);
  std::vector<Vec3f> points(700);
  for (Vec3f& p : points) {
    for (int a = 0; a < 3; ++a) p[a] = static_cast<float>(random.below(5));
  }
  expect_distances(points);
  expect_distances(std::vector<Vec3f>(300, Vec3f(1, 2, 3)));
  expect_distances({Vec3f(1, 2, 3)});
}

}  // namespace
}  // namespace plumbline
