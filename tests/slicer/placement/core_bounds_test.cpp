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

}  // namespace
}  // namespace plumbline
