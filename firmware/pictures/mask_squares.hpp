#pragma once
/// Counts the pixels of a mask in squares.

#include <algorithm>
#include <array>
#include <cstdint>

#include "slicer/core/bit_image.hpp"

namespace plumbline::firmware::inline pictures {

/// Squares of a mask's pixels, row after row. Those at its end may be cut.
struct MaskSquares {
  std::uint32_t column = 0, row = 0;    ///< the first pixel
  std::uint32_t side = 1;               ///< pixels of a square, 1 to 64
  std::uint32_t columns = 0, rows = 0;  ///< squares, at most kMost; none begins beyond the mask
  static constexpr std::uint32_t kMost = 640;

  /// How many pixels a square has.
  std::uint32_t pixels(ConstBitImage mask, std::uint32_t x, std::uint32_t y) const {
    return std::min(side, mask.columns() - column - x * side) * std::min(side, mask.rows() - row - y * side);
  }
};

/// The smallest squares of which so many show a part of a mask along each side.
/// @param columns, rows  pixels of the part
inline MaskSquares squares_of(std::uint32_t column, std::uint32_t row, std::uint32_t columns, std::uint32_t rows,
                              std::uint32_t most) {
  const std::uint32_t side = (std::max(columns, rows) + most - 1) / most;  // a grid has at most 16384 pixels a side
  return {column, row, side, (columns + side - 1) / side, (rows + side - 1) / side};
}

/// Calls visit(x, y, pixels that are set, pixels) for each square.
/// @param word_at  a row's word: word_at(row, word)
template <class WordAt, class Visit>
void for_each_square(ConstBitImage mask, const MaskSquares& squares, WordAt word_at, Visit visit) {
  std::array<std::uint32_t, MaskSquares::kMost> sums;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (std::uint32_t y = 0; y < squares.rows; ++y) {
    sums.fill(0);
    const std::uint32_t first = squares.row + y * squares.side;
    const std::uint32_t end = std::min(first + squares.side, mask.rows());
    for (std::uint32_t row = first; row < end; ++row) {
      for (std::uint32_t x = 0; x < squares.columns; ++x) {
        const std::uint32_t begin = squares.column + x * squares.side;
        const std::uint32_t count = std::min(squares.side, mask.columns() - begin), shift = begin % 64;
        std::uint64_t bits = word_at(row, begin / 64) >> shift;
        if (shift + count > 64) bits |= word_at(row, begin / 64 + 1) << (64 - shift);
        if (count < 64) bits &= (std::uint64_t{1} << count) - 1;
        sums[x] += count_ones(bits);
      }
    }
    for (std::uint32_t x = 0; x < squares.columns; ++x) visit(x, y, sums[x], squares.pixels(mask, x, y));
  }
}

}  // namespace plumbline::firmware::inline pictures
