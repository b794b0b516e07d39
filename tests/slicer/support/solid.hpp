#pragma once
/// R-Reps of solids given by formulas, and their masks with and without supports.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "slicer/supports/drawing/supports.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/pixels.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {

/// Whether the voxel (column, row, layer) is inside.
using Inside = std::function<bool(std::uint32_t, std::uint32_t, std::uint32_t)>;

/// Built by the definition of the R-Rep: pixels that differ from the layer below are toggled.
struct Solid {
  Solid(const PrintGrid& grid, const Inside& inside) {
    const CrossingPacking packing(grid);
    std::vector<bool> before(std::size_t{grid.columns} * grid.rows);
    for (std::uint32_t k = 0; k < grid.layers; ++k) {
      first.push_back(static_cast<std::uint32_t>(packed.size()));
      for (std::uint32_t p = 0; p < before.size(); ++p) {
        const bool now = inside(p % grid.columns, p / grid.columns, k);
        if (now != before[p]) packed.push_back(packing.packed(p));
        before[p] = now;
      }
    }
    first.push_back(static_cast<std::uint32_t>(packed.size()));
    rrep = {grid, first, packed};
  }
  /// Supports edit an R-Rep at the bottom of an arena. This one must outlive the solid's use.
  void move_to(Arena& arena) {
    const auto copy = [&](const std::vector<std::uint32_t>& from) {
      const auto to = value_of(arena.take_bottom<std::uint32_t>(from.size(), "test"));
      std::copy(from.begin(), from.end(), to.begin());
      return to;
    };
    rrep.first = copy(first);
    rrep.packed = copy(packed);
  }

  Solid(const Solid&) = delete;
  Solid& operator=(const Solid&) = delete;

  std::vector<Pixels> masks(const Supports* supports = nullptr) const {
    ArenaBlock arena(4 * kMiB);
    const Supports none;
    MaskStream stream = value_of(MaskStream::create(rrep, supports != nullptr ? *supports : none, *arena));
    std::vector<Pixels> all;
    for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) all.emplace_back(stream.mask(k));
    return all;
  }

  std::vector<std::uint32_t> first, packed;
  RRep rrep;
};

inline PrintGrid cubic_grid(std::uint32_t side, std::uint32_t layers, float pitch_mm = 0.1F) {
  return {.columns = side,
          .rows = side,
          .layers = layers,
          .pitch_x_mm = pitch_mm,
          .pitch_y_mm = pitch_mm,
          .layer_height_mm = pitch_mm};
}

/// Its middle in voxels.
inline Inside ball(double x, double y, double z, double radius) {
  return [=](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const double dx = c + 0.5 - x;
    const double dy = r + 0.5 - y;
    const double dz = k + 0.5 - z;
    return dx * dx + dy * dy + dz * dz < radius * radius;
  };
}

/// Half-open box of voxels.
struct Block {
  std::uint32_t column, column_end, row, row_end, layer, layer_end;
  bool has(std::uint32_t c, std::uint32_t r, std::uint32_t k) const {
    return column <= c && c < column_end && row <= r && r < row_end && layer <= k && k < layer_end;
  }
};
inline Inside blocks(const std::vector<Block>& all) {
  return [all](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return std::any_of(all.begin(), all.end(), [&](const Block& block) { return block.has(c, r, k); });
  };
}

}  // namespace plumbline::testing
