#pragma once
/// Spans of columns of a BitImage, 64 pixels at once.

#include <bit>
#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"

namespace plumbline::inline slicer {

/// Calls visit(word, bits) for the words of a row that hold columns [begin, end), begin < end.
template <class Visit>
void for_each_word(std::uint32_t begin, std::uint32_t end, Visit visit) {
  const std::uint32_t first = begin / 64;
  const std::uint32_t last = (end - 1) / 64;
  for (std::uint32_t w = first; w <= last; ++w) {
    std::uint64_t bits = ~std::uint64_t{0};
    if (w == first) bits &= ~std::uint64_t{0} << (begin % 64);
    if (w == last) bits &= ~std::uint64_t{0} >> (63 - (end - 1) % 64);
    visit(w, bits);
  }
}

/// Makes columns [begin, end) of a row white or black, begin < end.
inline void fill(BitImage image, std::uint32_t row, std::uint32_t begin, std::uint32_t end, bool white) {
  const auto line = image.row(row);
  for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) { white ? line[w] |= bits : line[w] &= ~bits; });
}

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

}  // namespace plumbline::inline slicer
