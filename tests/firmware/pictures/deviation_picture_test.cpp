#include "firmware/pictures/deviation_picture.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/slicer/support/solid.hpp"

namespace plumbline::firmware {
namespace {

TEST(DeviationPicture, HasTheColourOfEachPlaceInItsViews) {
  // A box of 4 x 2 x 4 mm: too little on the left half of its front, too much on the right half; its top and left side are true.
  const PrintGrid grid = testing::cubic_grid(60, 40);
  const testing::Solid box(grid, testing::blocks({{10, 50, 10, 30, 0, 40}}));
  std::vector<OrientedPoint> points;
  std::vector<float> deviations_mm;
  for (float a = 0.05F; a < 4; a += 0.1F) {
    for (float b = 0.05F; b < 4; b += 0.1F) {
      points.push_back({{1 + a, 1, b}, -Vec3f::UnitY()});
      deviations_mm.push_back(a < 2 ? -0.25F : 0.25F);
      points.push_back({{1 + a, 3, b}, Vec3f::UnitY()});  // the back, which no view shows
      deviations_mm.push_back(0.25F);
      if (b > 2) continue;
      points.push_back({{1 + a, 1 + b, 4}, Vec3f::UnitZ()});
      deviations_mm.push_back(0);
      points.push_back({{1, 1 + b, a}, -Vec3f::UnitX()});
      deviations_mm.push_back(0);
    }
  }
  std::vector<std::byte> memory(preview_bytes(grid) + Arena::kAlignment);
  Arena arena(memory);
  std::vector<std::uint8_t> rgb(kPageBytes);
  ASSERT_TRUE(draw_deviation(box.rrep, {}, {}, points, deviations_mm, arena, rgb));
  EXPECT_EQ(arena.used(), 0U);
  struct Seen {
    double blue = 0, red = 0, white = 0, blue_column = 0, red_column = 0;
  };
  Seen seen;
  for (std::uint32_t row = 125; row < 730; ++row) {
    for (std::uint32_t column = 0; column < kPreviewColumns; ++column) {
      const std::uint8_t* const p = &rgb[3 * (std::size_t{row} * kPreviewColumns + column)];
      const int r = p[0], g = p[1], b = p[2];
      if (b > r + 80 && b > g + 60) ++seen.blue, seen.blue_column += column;
      if (r > b + 80 && r > g + 80) ++seen.red, seen.red_column += column;
      if (std::min({r, g, b}) > 120 && std::max({r, g, b}) - std::min({r, g, b}) < 20) ++seen.white;
    }
  }
  EXPECT_GT(seen.blue, 10'000);
  EXPECT_NEAR(seen.red / seen.blue, 1, 0.1);
  EXPECT_LT(seen.blue_column / seen.blue, seen.red_column / seen.red) << "x runs to the right";
  EXPECT_NEAR(seen.white / (seen.red + seen.blue), (8 + 8) / 16.0, 0.15) << "left side and top";
}

}  // namespace
}  // namespace plumbline::firmware
