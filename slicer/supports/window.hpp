#pragma once
/// The part of the panel that the object covers.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "slicer/rrep/rrep.hpp"

namespace plumbline {

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
  const std::uint32_t columns = rrep.grid.columns;
  Window window{rrep.grid.rows, 0, (columns + 63) / 64, 0};
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
    std::uint32_t row = 0;
    std::uint32_t row_start = 0;
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) {
      while (rrep.pixel[i] - row_start >= columns) {  // pixels ascend: no division
        row_start += columns;
        ++row;
      }
      const std::uint32_t word = (rrep.pixel[i] - row_start) / 64;
      window.row = std::min(window.row, row);
      window.row_end = std::max(window.row_end, row + 1);
      window.word = std::min(window.word, word);
      window.word_end = std::max(window.word_end, word + 1);
    }
  }
  return window.row_end == 0 ? Window{} : window;
}

}  // namespace plumbline
