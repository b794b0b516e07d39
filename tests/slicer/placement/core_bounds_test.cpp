#include "slicer/placement/core_bounds.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

TEST(CoreBounds, LeavesOutATwentiethAtEachEndOfEachAxis) {
  std::vector<Vec3f> points;
  for (int i = 0; i < 1000; ++i) {
    points.emplace_back(static_cast<float>(i), static_cast<float>(-2 * i), static_cast<float>((i * 7) % 1000));
  }
  testing::ArenaBlock arena(std::size_t{1} << 20U);
  const auto box = core_bounds(points, *arena);
  ASSERT_TRUE(box);
  EXPECT_EQ(box->low, Vec3f(50, -2 * 949, 50));
  EXPECT_EQ(box->high, Vec3f(949, -2 * 50, 949));
  EXPECT_EQ(arena->used(), 0U);
}

TEST(CoreBounds, OfAFewPointsAreTheirBounds) {
  const std::vector<Vec3f> points = {Vec3f(1, 2, 3), Vec3f(3, 2, 1)};
  testing::ArenaBlock arena(4096);
  const auto box = core_bounds(points, *arena);
  ASSERT_TRUE(box);
  EXPECT_EQ(box->low, Vec3f(1, 2, 1));
  EXPECT_EQ(box->high, Vec3f(3, 2, 3));
}

/// Flying points far away and near, and a distant piece that has fewer points than the object.
TEST(DenseBounds, AreThoseOfTheObjectToACell) {
  testing::Random random(3);
  std::vector<Vec3f> points;
  for (const auto& p : testing::sphere(20000, 10, {5, 0, 0})) points.push_back(p.position.cast<float>());
  for (const auto& p : testing::sphere(500, 2, {30, 0, 0})) points.push_back(p.position.cast<float>());
  for (int i = 0; i < 100; ++i) points.push_back((20 * random.vector()).cast<float>());
  points.emplace_back(1e6F, -1e7F, 0);
  testing::ArenaBlock arena(std::size_t{1} << 20U);
  const auto core = core_bounds(points, *arena);
  ASSERT_TRUE(core);
  const auto box = dense_bounds(points, *core, *arena);
  ASSERT_TRUE(box);
  const float cell = core->size().maxCoeff() / 20;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(box->low[axis], (axis == 0 ? 5 : 0) - 10, cell);
    EXPECT_NEAR(box->high[axis], (axis == 0 ? 5 : 0) + 10, cell);
  }
  EXPECT_EQ(arena->used(), 0U);
}

}  // namespace
}  // namespace plumbline
