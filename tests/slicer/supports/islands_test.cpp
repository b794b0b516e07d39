#include "slicer/supports/islands.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/hanging.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

std::vector<IslandFinder::Place> islands_of(const Pixels& mask, const Pixels& below) {
  Pixels fresh(mask.columns(), mask.rows());
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    for (std::uint32_t c = 0; c < mask.columns(); ++c) fresh.set(c, r, mask.at(c, r) && !below.at(c, r));
  }
  const OwnedImage images[] = {mask.image(), below.image(), fresh.image()};
  const Window window{0, mask.rows(), 0, (mask.columns() + 63) / 64};
  ArenaBlock arena(kMiB);
  IslandFinder finder = value_of(IslandFinder::create(mask.columns(), *arena));
  EXPECT_EQ(arena->top_used(), IslandFinder::bytes_needed(mask.columns()));
  std::vector<IslandFinder::Place> found;
  for (int twice = 0; twice < 2; ++twice) {  // the first layer must not affect the second
    found.clear();
    const auto add = [&](const IslandFinder::Place& place) { found.push_back(place); };
    for (std::uint32_t r = 0; r < mask.rows(); ++r) {
      finder.next_row(images[0].view(), images[1].view(), images[2].view(), r, window, add);
    }
    finder.end(add);
  }
  return found;
}

TEST(Islands, AreThoseOfAFloodFill) {
  Random random(11);
  for (int i = 0; i < 300; ++i) {
    const std::uint32_t columns = 1 + random.below(200);
    const std::uint32_t rows = 1 + random.below(40);
    const std::uint32_t dense = 1 + random.below(7);
    Pixels mask(columns, rows);
    Pixels below(columns, rows);
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        mask.set(c, r, random.below(8) < dense);
        below.set(c, r, random.below(30) == 0);
      }
    }
    const auto found = islands_of(mask, below);
    EXPECT_EQ(found.size(), floating_islands({below, mask})) << columns << " x " << rows;
    // Each place is in an island of its own: with a pixel below each, no island is left.
    for (const auto& place : found) {
      EXPECT_TRUE(mask.at(place.column, place.row));
      below.set(place.column, place.row, true);
    }
    EXPECT_EQ(floating_islands({below, mask}), 0U);
  }
}

TEST(Islands, HaveTheirTipInTheMiddleOfTheirWidestRow) {
  Pixels mask(140, 30);
  for (std::uint32_t r = 0; r < 30; ++r) {
    for (std::uint32_t c = 0; c < 140; ++c) {
      const int dx = static_cast<int>(c) - 66;
      const int dy = static_cast<int>(r) - 15;
      mask.set(c, r, dx * dx + dy * dy < 100);
    }
  }
  const auto found = islands_of(mask, Pixels(140, 30));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].column, 66, 1);
  EXPECT_NEAR(found[0].row, 15, 5);
}

TEST(Islands, AreNotHeldAtACorner) {
  Pixels mask(10, 10);
  Pixels below(10, 10);
  for (const std::uint32_t c : {2U, 3U}) {
    for (const std::uint32_t r : {2U, 3U}) {
      mask.set(c, r, true);
      mask.set(c + 2, r + 2, true);  // meets the other at a corner
    }
  }
  below.set(2, 2, true);
  const auto found = islands_of(mask, below);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_GE(found[0].column, 4U);
}

}  // namespace
}  // namespace plumbline
