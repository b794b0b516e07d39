#include "slicer/checks/overhangs.hpp"

#include <algorithm>

#include "slicer/core/bit_spans.hpp"

namespace plumbline::inline slicer {

std::uint64_t erode_fresh(ConstBitImage fresh, const RegionBox& box, std::uint32_t reach, BitImage out) {
  bool any = false;
  for (std::uint32_t r = box.row; r < box.row_end; ++r) {
    for_each_run(fresh.row(r), [&](std::uint32_t begin, std::uint32_t end) {
      const std::uint32_t from = begin == box.column ? begin : begin + reach;
      const std::uint32_t to = end == box.column_end ? end : end - std::min(end, reach);
      if (from >= to) return;
      fill(out, r, from, to, true);
      any = true;
    });
  }
  if (!any) return 0;
  std::uint64_t left = 0;
  for (std::uint32_t r = box.row; r < box.row_end; ++r) {
    const std::uint32_t from = std::max(box.row, r - std::min(r, reach));
    const std::uint32_t to = std::min(box.row_end, r + reach + 1);
    const auto line = out.row(r);
    for (std::uint32_t w = 0; w < line.size(); ++w) {
      for (std::uint32_t k = from; line[w] != 0 && k < to; ++k) line[w] &= fresh.row(k)[w];
      left += count_ones(line[w]);
    }
  }
  return left;
}

}  // namespace plumbline::inline slicer
