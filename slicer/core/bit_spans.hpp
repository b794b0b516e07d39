#pragma once
/// Spans of columns of a BitImage, 64 pixels at once.

#include <cstdint>

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

}  // namespace plumbline::inline slicer
