#pragma once
/// A small R-Rep in its own arena, to be edited and compared voxel by voxel.

#include <algorithm>
#include <cstdint>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline::testing {

inline constexpr std::uint32_t kColumns = 70;
inline constexpr std::uint32_t kRows = 40;
inline constexpr std::uint32_t kLayers = 30;

/// The R-Rep of a solid at the bottom of an arena, as it is after building.
struct Voxels {
  ArenaBlock block{8 * kMiB};
  RRep rrep;

  explicit Voxels(const Inside& inside) : rrep{{.columns = kColumns, .rows = kRows, .layers = kLayers}, {}, {}} {
    const Solid solid(rrep.grid, inside);
    const auto first = value_of(block->take_bottom<std::uint32_t>(solid.first.size(), "test"));
    const auto packed = value_of(block->take_bottom<std::uint32_t>(solid.packed.size(), "test"));
    std::copy(solid.first.begin(), solid.first.end(), first.begin());
    std::copy(solid.packed.begin(), solid.packed.end(), packed.begin());
    rrep.first = first;
    rrep.packed = packed;
  }
  bool equals(const Inside& inside) const {
    const Solid wanted(rrep.grid, inside);
    return std::equal(wanted.first.begin(), wanted.first.end(), rrep.first.begin(), rrep.first.end()) &&
           std::equal(wanted.packed.begin(), wanted.packed.end(), rrep.packed.begin(), rrep.packed.end());
  }
};

}  // namespace plumbline::testing
