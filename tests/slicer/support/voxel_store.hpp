#pragma once
/// Voxels, and the crossings of the rays through them.

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "slicer/rrep/crossing_store.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {

/// Solid and hollow voxels.
struct Voxels {
  PrintGrid grid;
  std::vector<std::uint8_t> solid;

  Voxels(std::uint32_t columns, std::uint32_t rows, std::uint32_t layers)
      : grid{.columns = columns, .rows = rows, .layers = layers}, solid(std::size_t{columns} * rows * layers, 0) {}
  std::size_t at(std::uint32_t c, std::uint32_t r, std::uint32_t k) const {
    return (std::size_t{k} * grid.rows + r) * grid.columns + c;
  }
  void fill(std::array<std::uint32_t, 3> low, std::array<std::uint32_t, 3> high, bool with) {
    for (std::uint32_t k = low[2]; k < high[2]; ++k) {
      for (std::uint32_t r = low[1]; r < high[1]; ++r) {
        for (std::uint32_t c = low[0]; c < high[0]; ++c) solid[at(c, r, k)] = with ? 1 : 0;
      }
    }
  }
};

inline CrossingStore store_of(const Voxels& voxels, Arena& arena) {
  constexpr std::uint32_t kSide = kTileSide;
  CrossingStore store = value_of(CrossingStore::create(voxels.grid, arena));
  for (std::uint32_t t = 0; t < store.tile_columns() * store.tile_rows(); ++t) {
    std::vector<std::uint8_t> counts(std::size_t{kSide} * kSide, 0);
    std::vector<CrossingHeight> heights;
    for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
      const std::uint32_t c = t % store.tile_columns() * kSide + i % kSide;
      const std::uint32_t r = t / store.tile_columns() * kSide + i / kSide;
      if (c >= voxels.grid.columns || r >= voxels.grid.rows) continue;
      std::uint8_t before = 0;
      for (std::uint32_t k = 0; k <= voxels.grid.layers; ++k) {
        const std::uint8_t now = k < voxels.grid.layers ? voxels.solid[voxels.at(c, r, k)] : 0;
        if (now != before) {
          heights.emplace_back(k);
          ++counts[i];
        }
        before = now;
      }
    }
    EXPECT_TRUE(store.put(t, counts, heights).has_value());
  }
  check(store.close(arena));
  return store;
}

}  // namespace plumbline::testing
