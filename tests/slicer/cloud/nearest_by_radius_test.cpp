#include "slicer/cloud/nearest_by_radius.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// Asks for the nearest of every point and of places between, with KdTree::nearest() as the oracle.
void expect_nearest(const std::vector<Vec3f>& points) {
  ArenaBlock arena(4 * kMiB);
  const KdTree3 tree = value_of(KdTree3::build(points, *arena, "test"));
  const auto accept = [](std::uint32_t i) { return i % 5 != 1; };
  for (const std::uint32_t wanted : {1U, 2U, 61U, 256U}) {
    float radius = 0;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const Vec3f query = i % 3 == 0 ? Vec3f((points[i] + points[0]) / 2) : points[i];
      std::vector<Neighbour> expected(wanted);
      expected.resize(tree.nearest(query, expected, accept));
      NearestRoom room;
      const auto order = i % 2 == 0 ? NearestOrder::kOfSearch : NearestOrder::kOfPoints;
      const auto by_radius = nearest_by_radius(tree, query, radius, wanted, room, order, accept);
      std::vector<Neighbour> found(by_radius.begin(), by_radius.end());
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t k = 0; k < found.size(); ++k) {
        ASSERT_EQ(found[k].index, expected[k].index) << "wanted " << wanted << ", point " << i;
        ASSERT_EQ(found[k].distance2, expected[k].distance2);
      }
      radius = 1.3F * std::sqrt(found.back().distance2);
    }
  }
}

TEST(NearestByRadius, FindsThePointsThatTheTreeFinds) {
  Random random(11);
  std::vector<Vec3f> points(3000);
  for (Vec3f& p : points) {
    p = Vec3d(random.uniform(0, 30), random.uniform(0, 30), random.uniform(0, 1)).cast<float>();
  }
  expect_nearest(points);
}

TEST(NearestByRadius, FindsItsWayFromDenseToSparse) {
  Random random(12);
  std::vector<Vec3f> points;
  for (int n = 0; n < 2000; ++n) {
    const double size = n % 4 == 0 ? 100 : 0.01;  // a few hundred points all over, the rest in one place
    points.push_back(Vec3d(random.uniform(0, size), random.uniform(0, size), random.uniform(0, size)).cast<float>());
  }
  expect_nearest(points);
}

TEST(NearestByRadius, BearsEqualDistancesAndEqualPoints) {
  Random random(13);
  std::vector<Vec3f> points(700);
  for (Vec3f& p : points) {
    for (int a = 0; a < 3; ++a) p[a] = static_cast<float>(random.below(5));
  }
  expect_nearest(points);
  expect_nearest(std::vector<Vec3f>(300, Vec3f(1, 2, 3)));
  expect_nearest({Vec3f(1, 2, 3)});
}

}  // namespace
}  // namespace plumbline
