#pragma once
/// Finds overhangs as UVtools does: new pixels that remain when they are eroded.

#include <algorithm>
#include <cstdint>

#include "slicer/core/bit_image.hpp"

namespace plumbline::inline slicer {

/// Half-open box of pixels.
struct RegionBox {
  std::uint32_t column = ~std::uint32_t{0}, column_end = 0, row = ~std::uint32_t{0}, row_end = 0;

  bool empty() const { return column >= column_end; }
};
inline RegionBox joined(const RegionBox& a, const RegionBox& b) {
  return {std::min(a.column, b.column), std::max(a.column_end, b.column_end), std::min(a.row, b.row),
          std::max(a.row_end, b.row_end)};
}

/// Keeps in `out` the pixels of `fresh` that have nothing but fresh pixels within `reach` to the left, right, above and
/// below, as an erosion with a plus-shaped kernel of 2 reach + 1 pixels would. Beyond `box` nothing counts: UVtools erodes the
/// bounding box of the layer and the one below, mirrored at its sides, which is the same.
///
/// @param fresh  pixels of the layer that the one below has not; none outside of `box`
/// @param out    same size, black on entry
/// @returns number of pixels that are left
std::uint64_t erode_fresh(ConstBitImage fresh, const RegionBox& box, std::uint32_t reach, BitImage out);

}  // namespace plumbline::inline slicer
