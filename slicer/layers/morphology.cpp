#include "slicer/layers/morphology.hpp"

#include <algorithm>

namespace plumbline {
namespace {

/// A word, two columns before it and two after: bit b of both together is column b - 2 of the word.
struct Window {
  std::uint64_t low = 0, high = 0;

  Window operator&(const Window& o) const { return {low & o.low, high & o.high}; }
  Window operator|(const Window& o) const { return {low | o.low, high | o.high}; }
  /// Each column takes the value of the next one.
  Window from_next() const { return {low >> 1 | high << 63, high >> 1}; }
  /// Each column takes the value of the one before.
  Window from_previous() const { return {low << 1, high << 1 | low >> 63}; }
  std::uint64_t word() const { return low >> kOpenCloseReach | high << (64 - kOpenCloseReach); }
};

Window load(ConstBitImage image, std::int64_t row, std::uint32_t word) {
  static_assert(kOpenCloseReach == 2);
  if (row < 0 || row >= image.rows()) return {};
  const std::uint64_t* const at = &image.words()[static_cast<std::size_t>(row) * image.stride() + word];
  const std::uint64_t before = word > 0 ? at[-1] : 0;
  const std::uint64_t after = word + 1 < image.stride() ? at[1] : 0;
  return {at[0] << 2 | before >> 62, at[0] >> 62 | (after & 3U) << 2};
}

/// White where the pixel, the next one and the two below them are white.
Window erode(const Window& row, const Window& below) {
  const Window both = row & below;
  return both & both.from_next();
}
/// White where the pixel, the one before or one of the two above them is white.
Window dilate(const Window& above, const Window& row) {
  const Window either = above | row;
  return either | either.from_previous();
}

}  // namespace

void open_and_close_rows(ConstBitImage in, BitImage out, std::uint32_t word, std::uint32_t first, std::uint32_t last) {
  const std::uint64_t valid = word + 1 == out.stride() ? out.last_word_mask() : ~std::uint64_t{0};
  Window row;      // of the image
  Window eroded;   // of its opening, half done
  Window opened;   // of its opening
  Window dilated;  // of its closing, half done
  constexpr std::int64_t kReach = kOpenCloseReach;
  for (std::int64_t r = first - kReach; r < last + kReach; ++r) {
    const Window next_row = load(in, r, word);
    const Window next_eroded = erode(row, next_row);
    const Window next_opened = dilate(eroded, next_eroded);
    const Window next_dilated = dilate(opened, next_opened);
    if (r >= first + kReach) {
      out.row(static_cast<std::uint32_t>(r - kReach))[word] = erode(dilated, next_dilated).word() & valid;
    }
    row = next_row;
    eroded = next_eroded;
    opened = next_opened;
    dilated = next_dilated;
  }
}

void open_and_close(ConstBitImage in, BitImage out) {
  for (std::uint32_t w = 0; w < in.stride(); ++w) open_and_close_rows(in, out, w, 0, in.rows());
}

}  // namespace plumbline
