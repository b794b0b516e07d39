#include "slicer/mesh/open/lone_columns.hpp"

#include <gtest/gtest.h>

#include "tests/slicer/support/voxel_store.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(LoneColumns, AreRemovedAndNothingElse) {
  constexpr std::uint32_t kLayers = 90;
  Voxels voxels(30, 30, kLayers);
  voxels.fill({10, 10, 20}, {20, 20, 60}, true);
  const std::uint64_t body = 10 * 10 * 40;
  std::uint64_t kept = body;
  const auto fill = [&](std::array<std::uint32_t, 3> low, std::array<std::uint32_t, 3> high, bool stays) {
    voxels.fill(low, high, true);
    if (stays) kept += std::uint64_t{high[0] - low[0]} * (high[1] - low[1]) * (high[2] - low[2]);
  };
  fill({3, 3, 0}, {4, 4, 80}, false);           // in the air
  fill({29, 0, 0}, {30, 1, kLayers}, false);    // at the corner
  fill({12, 12, 60}, {13, 13, kLayers}, true);  // on the body: one interval with it, which rays around have half of
  fill({15, 15, 65}, {16, 16, 88}, false);      // over it
  fill({5, 25, 0}, {6, 26, kLeastColumnLayers - 1}, true);
  fill({24, 4, 0}, {25, 5, 40}, true);  // a wall across the diagonal
  fill({25, 5, 0}, {26, 6, 40}, true);
  fill({2, 20, 0}, {3, 21, 50}, true);  // a pin of 1 x 2 pixels
  fill({2, 21, 0}, {3, 22, 30}, true);
  ArenaBlock arena(4 * kMiB);
  CrossingStore store = store_of(voxels, *arena);
  EXPECT_EQ(value_of(drop_lone_columns(store, *arena)), 3U);
  EXPECT_EQ(value_of(drop_lone_columns(store, *arena)), 0U);
  const RRep rrep = value_of(CrossingStore::sort(store, *arena));
  EXPECT_EQ(store.section_pixels(), kept);
  EXPECT_GT(rrep.crossings(), 0U);
}

TEST(LoneColumns, AreRemovedHoweverManyTheyAre) {
  Voxels voxels(256, 256, 24);
  for (std::uint32_t r = 1; r < 256; r += 3) {
    for (std::uint32_t c = 1; c < 256; c += 3) voxels.fill({c, r, 0}, {c + 1, r + 1, 24}, true);
  }
  ArenaBlock arena(8 * kMiB);
  CrossingStore store = store_of(voxels, *arena);
  EXPECT_EQ(value_of(drop_lone_columns(store, *arena)), 85U * 85U);
}

}  // namespace
}  // namespace plumbline
