#pragma once
/// The part of the panel that an object covers.

#include <cstdint>

#include "slicer/core/bit_image.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// Half-open ranges of pixels: columns from left to right, rows from top to bottom. Empty as long as nothing is in it.
struct MaskExtent {
  std::uint32_t left = UINT32_MAX, right = 0, top = UINT32_MAX, bottom = 0;

  bool empty() const { return left >= right; }
  void hold(ConstBitImage mask);
  /// Whether `margin` pixels on each side of the grid stay free.
  bool keeps_off_edge(const PrintGrid& grid, std::uint32_t margin) const {
    return left >= margin && top >= margin && right + margin <= grid.columns && bottom + margin <= grid.rows;
  }
};

/// Around all crossings, and with them all masks: opening and closing make nothing larger.
MaskExtent extent_of(const RRep& rrep);

}  // namespace plumbline::inline slicer
