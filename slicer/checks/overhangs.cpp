#include "slicer/checks/overhangs.hpp"

#include <algorithm>
#include <bit>

namespace plumbline::inline slicer {
namespace {

/// Calls visit(begin, end) for each run of white pixels of a row, columns [begin, end).
template <class Visit>
void for_each_run(std::span<const std::uint64_t> line, Visit visit) {
  std::uint32_t begin = 0;
  bool open = false;
  for (std::uint32_t w = 0; w < line.size(); ++w) {
    std::uint64_t rest = open ? ~line[w] : line[w];
    while (rest != 0) {
      const auto at = static_cast<std::uint32_t>(std::countr_zero(rest));
      if (open) {
        visit(begin, w * 64 + at);
      } else {
        begin = w * 64 + at;
      }
      open = !open;
      rest = (open ? ~line[w] : line[w]) & ~std::uint64_t{0} << at;
    }
  }
  if (open) visit(begin, static_cast<std::uint32_t>(line.size() * 64));
}

void set_run(std::span<std::uint64_t> line, std::uint32_t begin, std::uint32_t end) {
  for (std::uint32_t c = begin; c < end;) {
    const std::uint32_t bit = c % 64;
    const std::uint32_t length = std::min(end - c, 64 - bit);
    line[c / 64] |= (length == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << length) - 1) << bit;
    c += length;
  }
}

}  // namespace

std::uint64_t erode_fresh(ConstBitImage fresh, const RegionBox& box, std::uint32_t reach, BitImage out) {
  bool any = false;
  for (std::uint32_t r = box.row; r < box.row_end; ++r) {
    const auto line = out.row(r);
    for_each_run(fresh.row(r), [&](std::uint32_t begin, std::uint32_t end) {
      const std::uint32_t from = begin == box.column ? begin : begin + reach;
      const std::uint32_t to = end == box.column_end ? end : end - std::min(end, reach);
      if (from >= to) return;
      set_run(line, from, to);
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
