#pragma once
/// The regions of a layer as the peel sees them.

#include <algorithm>
#include <cstdint>
#include <utility>

#include "slicer/core/regions/layer_regions.hpp"

namespace plumbline::inline slicer {

struct RegionShape {
  std::uint32_t region = 0;                      ///< its name, white
  std::uint32_t column = 0, row = 0, width = 0;  ///< middle of its widest run
  std::uint32_t sides_x = 0, sides_y = 0;        ///< of its outline, holes included, pixels
};

/// Measures the white regions of a layer.
/// @param begin     called with (region, whether it is white) for each region but the outside, in the order of their names; returns whether
///                  to go on
/// @param shape_of  called with a white region that has begun: its RegionShape&, which is only set but for its name
/// @returns whether all began
template <class Begin, class ShapeOf>
[[nodiscard]] bool measure_regions(const LayerRegions& regions, Begin begin, ShapeOf shape_of) {
  std::uint32_t above = 0, above_end = 0;  // white runs of the row before
  for (std::uint32_t r = 0; r < regions.rows(); ++r) {
    const std::uint32_t first = regions.row_begin(r);
    const std::uint32_t end = regions.row_begin(r + 1);
    std::uint32_t k = std::exchange(above, first + 1);
    const std::uint32_t k_end = std::exchange(above_end, end);
    if (end - first == 1) continue;  // a black row
    for (std::uint32_t i = first; i < end; ++i) {
      const LayerRegions::Run run = regions.run(i);
      const std::uint32_t region = regions.region(i);
      const bool white = regions.white(r, i);
      if (region == i && run.first <= run.last && !begin(region, white)) return false;
      if (!white) continue;
      RegionShape& shape = shape_of(region);
      const std::uint32_t pixels = run.last + 1U - run.first;
      // Above and below, less the sides that two of its rows share, which both count.
      std::uint32_t shared = 0;
      for (; k < k_end; k += 2) {
        const LayerRegions::Run other = regions.run(k);
        const std::uint32_t from = std::max(run.first, other.first);
        const std::uint32_t to = std::min(run.last, other.last) + 1U;
        if (from < to) shared += to - from;
        if (other.last > run.last) break;
      }
      shape.sides_x += 2 * (pixels - shared);
      shape.sides_y += 2;
      if (pixels <= shape.width) continue;
      shape.width = pixels;
      shape.row = r;
      shape.column = run.first + pixels / 2;
    }
  }
  return true;
}

}  // namespace plumbline::inline slicer
