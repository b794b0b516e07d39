#include "slicer/rrep/mask_extent.hpp"

#include <algorithm>
#include <bit>

namespace plumbline::inline slicer {

void MaskExtent::hold(ConstBitImage mask) {
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    const auto row = mask.row(r);
    const auto is_white = [](std::uint64_t word) { return word != 0; };
    const auto first = std::find_if(row.begin(), row.end(), is_white);
    if (first == row.end()) continue;
    const auto last = std::find_if(row.rbegin(), row.rend(), is_white);
    const auto words_before = [&row](auto at) { return static_cast<std::uint32_t>(at - row.begin()); };
    left = std::min(left, 64 * words_before(first) + static_cast<std::uint32_t>(std::countr_zero(*first)));
    right = std::max(right, 64 * words_before(last.base()) - static_cast<std::uint32_t>(std::countl_zero(*last)));
    top = std::min(top, r);
    bottom = std::max(bottom, r + 1);
  }
}

MaskExtent extent_of(const RRep& rrep) {
  const std::uint32_t columns = rrep.grid.columns;
  const CrossingPacking packing(rrep.grid);
  MaskExtent extent;
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
    std::uint32_t row = 0;
    std::uint32_t row_start = 0;
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) {
      const std::uint32_t pixel = packing.pixel(rrep.packed[i]);
      while (pixel - row_start >= columns) {  // pixels ascend: no division
        row_start += columns;
        ++row;
      }
      extent.left = std::min(extent.left, pixel - row_start);
      extent.right = std::max(extent.right, pixel - row_start + 1);
      extent.top = std::min(extent.top, row);
      extent.bottom = std::max(extent.bottom, row + 1);
    }
  }
  return extent;
}

}  // namespace plumbline::inline slicer
