#include "slicer/rrep/mask_extent.hpp"

#include <algorithm>
#include <bit>

#include "slicer/rrep/row_walk.hpp"

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
    const auto layer = rrep.packed.subspan(rrep.first[k], rrep.first[k + 1] - rrep.first[k]);
    if (layer.empty()) continue;
    extent.top = std::min(extent.top, packing.pixel(layer.front()) / columns);
    extent.bottom = std::max(extent.bottom, packing.pixel(layer.back()) / columns + 1);
    RowWalk walk(columns);
    for (const std::uint32_t crossing : layer) {
      walk.go_to(packing.pixel(crossing));
      extent.left = std::min(extent.left, walk.column());
      extent.right = std::max(extent.right, walk.column() + 1);
    }
  }
  return extent;
}

}  // namespace plumbline::inline slicer
