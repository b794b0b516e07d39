#include "slicer/rrep/components.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/surfaces.hpp"
#include "tests/slicer/support/voxel_store.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// The voxels of the layers that the store's crossings make.
Voxels voxels_of(CrossingStore& store, Arena& arena) {
  const PrintGrid grid = store.grid();
  Voxels voxels(grid.columns, grid.rows, grid.layers);
  const RRep rrep = value_of(CrossingStore::sort(store, arena));
  std::vector<std::uint8_t> now(std::size_t{grid.columns} * grid.rows, 0);
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i)
      now[CrossingPacking(grid).pixel(rrep.packed[i])] ^= 1;
    std::copy(now.begin(), now.end(), voxels.solid.begin() + static_cast<std::ptrdiff_t>(k * now.size()));
  }
  return voxels;
}

/// Components by a flood from voxel to voxel.
class Flood {
 public:
  explicit Flood(const Voxels& voxels) : voxels_(voxels), component_(voxels.solid.size(), 0) {
    for (std::size_t v = 0; v < component_.size(); ++v) {
      if (component_[v] == 0) spread(v);
    }
  }
  /// Voxels of the component that holds v, and whether it reaches a side of the grid.
  std::size_t size(std::size_t v) const { return sizes_[component_[v] - 1]; }
  bool is_outside(std::size_t v) const { return voxels_.solid[v] == 0 && outside_[component_[v] - 1]; }
  std::size_t largest_solid() const {
    std::size_t most = 0;
    for (std::size_t v = 0; v < component_.size(); ++v) most = voxels_.solid[v] != 0 ? std::max(most, size(v)) : most;
    return most;
  }

 private:
  void spread(std::size_t start) {
    const auto [columns, rows, layers] = std::array{voxels_.grid.columns, voxels_.grid.rows, voxels_.grid.layers};
    const auto number = static_cast<std::uint32_t>(sizes_.size() + 1);
    std::vector<std::size_t> open{start};
    component_[start] = number;
    std::size_t size = 0;
    bool outside = false;
    while (!open.empty()) {
      const std::size_t v = open.back();
      open.pop_back();
      ++size;
      const std::size_t c = v % columns;
      const std::size_t r = v / columns % rows;
      const std::size_t k = v / columns / rows;
      outside = outside || c == 0 || r == 0 || k == 0 || c + 1 == columns || r + 1 == rows || k + 1 == layers;
      const auto visit = [&](bool inside, std::size_t next) {
        if (!inside || component_[next] != 0 || voxels_.solid[next] != voxels_.solid[start]) return;
        component_[next] = number;
        open.push_back(next);
      };
      const std::size_t plane = std::size_t{columns} * rows;
      visit(c > 0, v - 1);
      visit(c + 1 < columns, v + 1);
      visit(r > 0, v - columns);
      visit(r + 1 < rows, v + columns);
      visit(k > 0, v - plane);
      visit(k + 1 < layers, v + plane);
    }
    sizes_.push_back(size);
    outside_.push_back(outside);
  }

  const Voxels& voxels_;
  std::vector<std::uint32_t> component_;
  std::vector<std::size_t> sizes_;
  std::vector<bool> outside_;
};

/// Random boxes, solid and hollow, one in another, inside of a margin that stays hollow: so hollow parts that touch the grid's sides
/// are the outside.
Voxels random_boxes(Random& random) {
  Voxels voxels(40, 30, 35);
  for (int box = 0; box < 60; ++box) {
    std::array<std::uint32_t, 3> low{};
    std::array<std::uint32_t, 3> high{};
    const std::array<std::uint32_t, 3> sides{40, 30, 35};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = 1 + random.below(sides[a] - 2);
      high[a] = std::min(sides[a] - 1, low[a] + 1 + random.below(box < 20 ? 14 : 4));
    }
    voxels.fill(low, high, random.below(3) != 0);
  }
  return voxels;
}

TEST(Components, RemovesAndFillsWhatAFloodFromVoxelToVoxelFindsSmall) {
  Random random(11);
  constexpr std::size_t kSmall = 20;
  std::uint64_t removed = 0;
  for (int round = 0; round < 40; ++round) {
    const Voxels before = random_boxes(random);
    const Flood flood(before);
    const std::size_t largest_solid = flood.largest_solid();
    const std::size_t least = std::min(kSmall, std::max(kSmall / 4, largest_solid / 20));
    ArenaBlock arena(4 * kMiB);
    CrossingStore store = store_of(before, *arena);
    const std::size_t used = arena->used();
    const ComponentCounts counts = drop_small_components(store, {.min_voxels = kSmall}, *arena);
    ASSERT_TRUE(counts.counted);
    EXPECT_EQ(arena->used(), used);
    const Voxels after = voxels_of(store, *arena);
    std::uint64_t solid = 0;
    for (std::size_t v = 0; v < before.solid.size(); ++v) {
      const bool largest = before.solid[v] != 0 && flood.size(v) == largest_solid;
      const bool small = flood.size(v) < least && !flood.is_outside(v) && !largest;
      if (small)
        continue;  // one inside of another that changes stays: then it is of the same kind as what surrounds it
      ASSERT_EQ(after.solid[v], before.solid[v]) << "round " << round << ", voxel " << v;
      if (before.solid[v] != 0) ++solid;
    }
    EXPECT_GE(counts.voxels, solid) << "round " << round;
    removed += counts.dropped_solids + counts.filled_cavities;
    const Flood left(after);
    const std::size_t largest_left = left.largest_solid();
    for (std::size_t v = 0; v < after.solid.size(); ++v) {
      if (left.is_outside(v) || left.size(v) == largest_left) continue;
      ASSERT_GE(left.size(v), least) << "round " << round;
    }
  }
  EXPECT_GT(removed, 100U);
}

TEST(Components, PartsOfTheLargestSolidsSizeStayInASparseScan) {
  Voxels voxels(64, 24, 24);
  voxels.fill({2, 2, 2}, {22, 22, 22}, true);
  voxels.fill({30, 2, 2}, {40, 12, 6}, true);   // a 20th of it
  voxels.fill({30, 14, 2}, {40, 23, 5}, true);  // less
  voxels.fill({50, 2, 2}, {55, 12, 10}, true);  // a 20th
  const auto left = [&](std::uint64_t min_voxels) {
    ArenaBlock arena(4 * kMiB);
    CrossingStore store = store_of(voxels, *arena);
    return drop_small_components(store, {.min_voxels = min_voxels}, *arena).solids;
  };
  EXPECT_EQ(left(1000), 3U);
  EXPECT_EQ(left(1604), 1U) << "a quarter of the least voxels is what outliers make";
  EXPECT_EQ(left(250), 4U);
}

TEST(Components, TakeNoMoreThanTheirPlan) {
  Voxels voxels(200, 120, 40);
  voxels.fill({10, 10, 1}, {190, 110, 30}, true);
  for (std::uint32_t hole = 12; hole < 180; hole += 8) voxels.fill({hole, 20, 5}, {hole + 4, 100, 9}, false);
  ArenaBlock arena(4 * kMiB);
  CrossingStore store = store_of(voxels, *arena);
  arena->reset_peak();
  const std::size_t used = arena->used();
  const ComponentCounts counts = drop_small_components(store, {.min_voxels = 10}, *arena);
  EXPECT_EQ(counts.solids, 1U);
  EXPECT_EQ(counts.cavities, 21U);
  EXPECT_LE(arena->peak() - used, components_bytes(voxels.grid, 180 * 100, store.crossings()) + 8 * Arena::kAlignment);
}

TEST(Components, StayUncountedWhereThereIsNoRoomToLookForThem) {
  Voxels voxels(64, 64, 20);
  voxels.fill({10, 10, 1}, {50, 50, 15}, true);
  voxels.fill({60, 60, 1}, {61, 61, 2}, true);
  ArenaBlock plenty(kMiB);
  CrossingStore counted = store_of(voxels, *plenty);
  const std::size_t most = counted.bytes() + components_bytes(voxels.grid, 1601, counted.crossings());
  EXPECT_EQ(drop_small_components(counted, {.min_voxels = 10}, *plenty).dropped_solids, 1U);
  ArenaBlock little(most / 2);
  CrossingStore store = store_of(voxels, *little);
  const ComponentCounts counts = drop_small_components(store, {.min_voxels = 10}, *little);
  EXPECT_FALSE(counts.counted);
  EXPECT_EQ(counts.dropped_solids, 0U);
  EXPECT_EQ(store.crossings(), 2U * 1601U);
}

}  // namespace
}  // namespace plumbline
