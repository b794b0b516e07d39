#pragma once
/// Finds pixels that have a white pixel within a distance, 64 at a time.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/supports/drawing/disc.hpp"

namespace plumbline::inline slicer {

/// Pixels of word `w` of a row that have a white one of the row at most `reach` columns away. Some may lie past the last column.
std::uint64_t near_in_row(std::span<const std::uint64_t> row, std::uint32_t w, std::uint32_t reach);

/// A disc as a table of its half width in each row.
class Disc {
 public:
  Disc() = default;
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<Disc> create(const PixelPitch& pitch, Nanometres radius, Arena& arena);
  static std::size_t bytes_needed(const PixelPitch& pitch, Nanometres radius);

  /// Of the pixels `wanted` in a word of a row, those that have a white pixel of `image` within the disc's radius.
  std::uint64_t near(ConstBitImage image, std::uint32_t row, std::uint32_t word, std::uint64_t wanted) const;

  /// Makes white what is within the disc's radius of a white pixel of a line, which lies at `row` of the image.
  /// @param line   as wide as the image
  /// @param visit  called with (row, word, bits) for pixels that were black
  template <class Visit>
  void draw_near(std::span<const std::uint64_t> line, std::uint32_t row, BitImage image, Visit visit) const;

  std::uint32_t rows() const { return static_cast<std::uint32_t>(reach_.size()) - 1; }  ///< above and below the centre

 private:
  std::span<std::uint32_t> reach_;  ///< columns, by distance of the row from the centre
};

template <class Visit>
void Disc::draw_near(std::span<const std::uint64_t> line, std::uint32_t row, BitImage image, Visit visit) const {
  const auto draw = [&](std::uint32_t r, std::uint32_t w, std::uint64_t bits) {
    std::uint64_t& word = image.row(r)[w];
    bits &= ~word;
    if (bits == 0) return;
    word |= bits;
    visit(r, w, bits);
  };
  const auto stride = static_cast<std::uint32_t>(line.size());
  std::uint32_t first = 0;
  while (first < stride && line[first] == 0) ++first;
  std::uint32_t last = stride;
  while (last > first && line[last - 1] == 0) --last;
  if (first == last) return;
  const std::uint32_t margin = reach_[0] / 64 + 1;
  first -= std::min(first, margin);
  last = std::min(stride, last + margin);
  for (std::uint32_t w = first; w < last; ++w) {
    const std::uint64_t inside = w + 1 == stride ? image.last_word_mask() : ~std::uint64_t{0};
    for (std::uint32_t dy = 0; dy < reach_.size(); ++dy) {
      const std::uint64_t bits = near_in_row(line, w, reach_[dy]) & inside;
      if (bits == 0) break;  // the disc is narrower in the rows beyond
      if (dy <= row) draw(row - dy, w, bits);
      if (dy > 0 && row + dy < image.rows()) draw(row + dy, w, bits);
    }
  }
}

}  // namespace plumbline::inline slicer
