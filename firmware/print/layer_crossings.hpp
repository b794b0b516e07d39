#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline {

/// Collects the pixels that differ from the layer below, as long as there is room: an R-Rep, to draw masks that somebody else has made.
class LayerCrossings {
 public:
  /// Takes what the arena has left at its bottom, but for the pictures' own room.
  static LayerCrossings make(const PrintGrid& grid, Arena& arena);

  /// @param layer  each layer of the grid, in order
  /// @param below  the mask before it; empty below the first
  void next(std::uint32_t layer, ConstBitImage mask, ConstBitImage below);
  /// @returns an empty one if there was no room for all
  RRep rrep(const PrintGrid& grid) const;

 private:
  std::span<std::uint32_t> first_, pixel_;
  std::size_t count_ = 0;
  bool fits_ = false;
};

}  // namespace plumbline
