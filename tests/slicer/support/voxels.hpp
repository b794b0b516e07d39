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
    const auto pixel = value_of(block->take_bottom<std::uint32_t>(solid.pixel.size(), "test"));
    std::copy(solid.first.begin(), solid.first.end(), first.begin());
    std::copy(solid.pixel.begin(), solid.pixel.end(), pixel.begin());
    rrep.first = first;
    rrep.pixel = pixel;
  }
  bool equals(const Inside& inside) const {
    const Solid wanted(rrep.grid, inside);
    return std::equal(wanted.first.begin(), wanted.first.end(), rrep.first.begin(), rrep.first.end()) &&
           std::equal(wanted.pixel.begin(), wanted.pixel.end(), rrep.pixel.begin(), rrep.pixel.end());
  }
};

}  // namespace plumbline::testing
