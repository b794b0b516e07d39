#include "slicer/checks/slender_parts.hpp"

#include <gtest/gtest.h>

#include "tests/slicer/checks/checked_stack.hpp"

namespace plumbline {
namespace slender_parts_test {

using namespace testing;

constexpr std::uint32_t kSide = 90;  ///< pixels of 0.1 mm, as layers

IssueGroup needles(std::uint32_t layers, const Inside& inside) {
  return check(stack_of(kSide, layers, inside), {}).of(IssueKind::kNeedle);
}

TEST(SlenderParts, FindsAColumnEightyTimesAsHighAsItIsWide) {
  const auto on_a_base = [](std::uint32_t layers) {
    return needles(layers + 2, blocks({{10, 50, 10, 50, 0, 2}, {20, 25, 30, 35, 2, layers + 2}}));
  };
  const IssueGroup found = on_a_base(400);
  ASSERT_EQ(found.count, 1U);
  EXPECT_EQ(found.kept[0], (Issue{IssueKind::kNeedle, 2, 2, 401, 22, 30, 25, 25}));
  EXPECT_NEAR(IssueScale(cubic_grid(kSide, 402)).slenderness(found.kept[0]), 80, 1e-4);
  EXPECT_EQ(on_a_base(397).count, 0U) << "0.2 mm from look to look";
}

TEST(SlenderParts, FindsANeedleThatStandsOnThePlateLeansOrCarriesSomething) {
  EXPECT_EQ(needles(400, blocks({{20, 25, 30, 35, 0, 400}})).kept[0].first_layer, 0U);
  EXPECT_EQ(needles(410, blocks({{20, 25, 30, 35, 0, 400}, {10, 40, 20, 50, 400, 410}})).count, 1U);
  const Inside leans = [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return r >= 30 && r < 35 && c >= 5 + k / 10 && c < 10 + k / 10;
  };
  EXPECT_EQ(needles(400, leans).count, 1U);
  // Two that an arch joins.
  EXPECT_EQ(
      needles(410, blocks({{20, 25, 30, 35, 0, 400}, {40, 45, 30, 35, 0, 400}, {20, 45, 30, 35, 400, 410}})).count, 2U);
}

TEST(SlenderParts, IsSilentAboutFinsTubesAndBracedColumns) {
  EXPECT_EQ(needles(400, blocks({{20, 25, 10, 60, 0, 400}})).count, 0U) << "a fin";
  EXPECT_EQ(needles(1000, without(blocks({{20, 50, 20, 50, 0, 1000}}), blocks({{21, 49, 21, 49, 0, 1000}}))).count, 0U)
      << "a tube whose wall has 1.2 mm2";
  EXPECT_EQ(
      needles(400, blocks({{20, 25, 30, 35, 0, 400}, {40, 45, 30, 35, 0, 400}, {20, 45, 30, 35, 200, 205}})).count, 0U)
      << "a brace half way up";
}

IssueGroup walls(const Inside& inside, std::uint32_t layers = 40) {
  return check(stack_of(kSide, layers, inside), {}).of(IssueKind::kThinWall);
}

TEST(SlenderParts, FindsWallsOfOnePixelOrTwoAlongRowsOrColumns) {
  for (const std::uint32_t thick : {1U, 2U, 3U}) {
    const std::uint32_t count = thick < 3 ? 1 : 0;
    // Across the words of a row, too.
    for (const std::uint32_t at : {20U, 63U}) {
      const IssueGroup along = walls(blocks({{at, at + thick, 20, 50, 0, 40}}));
      EXPECT_EQ(along.count, count) << thick << " at column " << at;
      const IssueGroup across = walls(blocks({{50, 80, at, at + thick, 0, 40}}));
      EXPECT_EQ(across.count, count) << thick << " at row " << at;
      if (count == 0) continue;
      EXPECT_EQ(along.kept[0].pixels, 30U * thick);
      EXPECT_EQ(along.kept[0].column, at + thick / 2);
      EXPECT_EQ(across.kept[0].row, at);
      EXPECT_EQ(across.kept[0].column, 65U);
      EXPECT_GE(across.kept[0].last_layer, 37U);
    }
  }
}

TEST(SlenderParts, FindsWallsFromTwoMillimetresOn) {
  const auto wall = [](std::uint32_t length, std::uint32_t layers) {
    return walls(blocks({{20, 21, 20, 20 + length, 0, layers}, {30, 60, 20, 60, 0, 40}})).count;
  };
  EXPECT_EQ(wall(20, 40), 1U);
  EXPECT_EQ(wall(19, 40), 0U);
  EXPECT_EQ(wall(30, 20), 1U);
  EXPECT_EQ(wall(30, 18), 0U);
}

TEST(SlenderParts, FindsWallsOnABodyRoundAHollowAndWhereTheyLean) {
  EXPECT_EQ(walls(blocks({{20, 40, 20, 40, 0, 40}, {40, 70, 30, 32, 5, 38}})).count, 1U) << "a fin";
  const Inside box = without(blocks({{20, 60, 20, 60, 0, 40}}), blocks({{21, 59, 21, 59, 0, 40}}));
  EXPECT_EQ(walls(box).count, 1U) << "the four walls of a box are one";
  const Inside leans = [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return r >= 10 && r < 50 && c >= 20 + k / 2 + r / 8 && c < 22 + k / 2 + r / 8;
  };
  EXPECT_EQ(walls(leans).count, 1U);
  EXPECT_EQ(walls(blocks({{10, 40, 20, 21, 0, 40}, {50, 80, 20, 21, 0, 40}})).count, 2U);
}

TEST(SlenderParts, TakesNoEdgeOfASolidForAWall) {
  EXPECT_EQ(walls(ball(45, 45, 40, 38), 80).count, 0U);
  EXPECT_EQ(walls(blocks({{0, 90, 0, 90, 0, 40}})).count, 0U) << "up to the panel's edge";
  EXPECT_EQ(
      walls([](std::uint32_t c, std::uint32_t r, std::uint32_t k) { return r + k / 4 > 20 + c / 7 && r < 80; }).count,
      0U)
      << "steps of a slope";
}

}  // namespace slender_parts_test
}  // namespace plumbline
