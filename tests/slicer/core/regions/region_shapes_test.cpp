#include "slicer/core/regions/region_shapes.hpp"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "slicer/core/bit_image.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(RegionShapes, HaveTheOutlinesOfTheirPixels) {
  constexpr std::uint32_t kWide = 131;
  constexpr std::uint32_t kHigh = 23;
  const LayerRegions::Settings settings{.runs_per_row = 80, .join_white_corners = false};
  Random random(1);
  ArenaBlock memory(std::size_t{4} << 20);
  auto regions = LayerRegions::create(kWide, kHigh, *memory, settings);
  ASSERT_TRUE(regions.has_value());
  for (const std::uint32_t percent : {0U, 2U, 30U, 55U, 60U, 90U, 100U}) {
    std::vector<std::uint64_t> words(BitImage::words_needed(kWide, kHigh));
    const BitImage image(words, kWide, kHigh);
    for (std::uint32_t r = 0; r < kHigh; ++r) {
      for (std::uint32_t c = 0; c < kWide; ++c) {
        if (random.below(100) < percent) image.set(c, r);
      }
    }
    ASSERT_TRUE(regions->label(image));
    std::map<std::uint32_t, RegionShape> shapes;
    std::uint32_t last = 0;
    ASSERT_TRUE(measure_regions(
        *regions,
        [&](std::uint32_t region, bool white) {
          EXPECT_LT(std::exchange(last, region), region);
          if (white) shapes[region] = {.region = region};
          return true;
        },
        [&](std::uint32_t region) -> auto& { return shapes.at(region); }));
    std::map<std::uint32_t, RegionShape> expected;
    const auto region_at = [&](std::uint32_t c, std::uint32_t r) { return regions->region(regions->run_at(c, r)); };
    for (std::uint32_t r = 0; r < kHigh; ++r) {
      std::uint32_t width = 0;
      for (std::uint32_t c = 0; c < kWide; ++c) {
        width = image.at(c, r) ? width + 1 : 0;
        if (width == 0) continue;
        RegionShape& shape = expected[region_at(c, r)];
        shape.sides_x += (r == 0 || !image.at(c, r - 1) ? 1U : 0U) + (r + 1 == kHigh || !image.at(c, r + 1) ? 1U : 0U);
        shape.sides_y += (width == 1 ? 1U : 0U) + (c + 1 == kWide || !image.at(c + 1, r) ? 1U : 0U);
        shape.width = std::max(shape.width, width);
      }
    }
    ASSERT_EQ(shapes.size(), expected.size());
    for (const auto& [region, shape] : shapes) {
      EXPECT_EQ(shape.sides_x, expected.at(region).sides_x);
      EXPECT_EQ(shape.sides_y, expected.at(region).sides_y);
      EXPECT_EQ(shape.width, expected.at(region).width);
      EXPECT_EQ(region_at(shape.column, shape.row), region);
    }
  }
}

}  // namespace
}  // namespace plumbline
