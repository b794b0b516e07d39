#pragma once
/// The part of the panel that the object covers.

#include <bit>
#include <cstdint>
#include <span>

#include "slicer/rrep/mask_extent.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// Half-open ranges of rows, and of words of 64 columns.
struct Window {
  std::uint32_t row = 0, row_end = 0;
  std::uint32_t word = 0, word_end = 0;

  std::uint32_t rows() const { return row_end - row; }
  std::uint32_t columns() const { return (word_end - word) * 64; }
};

/// Calls visit(word) for the words of a row that are marked, from left to right.
/// @param marks  one bit a word; may change meanwhile
template <class Visit>
void for_each_marked(std::span<const std::uint64_t> marks, Visit visit) {
  for (std::uint32_t i = 0; i < marks.size(); ++i) {
    for (std::uint64_t rest = marks[i]; rest != 0; rest &= rest - 1) {
      visit(i * 64 + static_cast<std::uint32_t>(std::countr_zero(rest)));
    }
  }
}

/// The smallest window that holds all crossings, and with them all masks: opening and closing make nothing larger.
inline Window window_of(const RRep& rrep) {
  const MaskExtent extent = extent_of(rrep);
  if (extent.empty()) return {};
  return {extent.top, extent.bottom, extent.left / 64, (extent.right + 63) / 64};
}

}  // namespace plumbline::inline slicer
