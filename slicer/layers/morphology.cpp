#include "slicer/layers/morphology.hpp"

namespace plumbline {
namespace {

/// A word with its two neighbours in the row; only their adjacent bits matter.
struct Triple {
  std::uint64_t before = 0, word = 0, after = 0;

  Triple operator&(const Triple& o) const { return {before & o.before, word & o.word, after & o.after}; }
  Triple operator|(const Triple& o) const { return {before | o.before, word | o.word, after | o.after}; }
  /// Bit c takes the value of bit c + 1.
  Triple from_next() const { return {before >> 1 | word << 63, word >> 1 | after << 63, after >> 1}; }
  /// Bit c takes the value of bit c - 1.
  Triple from_previous() const { return {before << 1, word << 1 | before >> 63, after << 1 | word >> 63}; }
};

Triple load(ConstBitImage image, std::int64_t row, std::uint32_t word) {
  if (row < 0 || row >= image.rows()) return {};
  const auto line = image.row(static_cast<std::uint32_t>(row));
  return {word > 0 ? line[word - 1] : 0, line[word], word + 1 < image.stride() ? line[word + 1] : 0};
}

/// White where the pixel, the next one and the two below them are white.
Triple erode(const Triple& row, const Triple& below) {
  const Triple both = row & below;
  return both & both.from_next();
}
/// White where the pixel, the one before or one of the two above them is white.
Triple dilate(const Triple& above, const Triple& row) {
  const Triple either = above | row;
  return either | either.from_previous();
}

}  // namespace

void open_and_close_run(ConstBitImage in, BitImage out, std::uint32_t row, std::uint32_t first, std::uint32_t last) {
  const auto target = out.row(row);
  for (std::uint32_t w = first; w < last; ++w) {
    const std::int64_t r = row;
    const Triple i0 = load(in, r - 2, w);
    const Triple i1 = load(in, r - 1, w);
    const Triple i2 = load(in, r, w);
    const Triple i3 = load(in, r + 1, w);
    const Triple i4 = load(in, r + 2, w);
    const Triple e0 = erode(i0, i1);
    const Triple e1 = erode(i1, i2);
    const Triple e2 = erode(i2, i3);
    const Triple e3 = erode(i3, i4);
    const Triple opened0 = dilate(e0, e1);  // rows r - 1, r, r + 1 of the opening
    const Triple opened1 = dilate(e1, e2);
    const Triple opened2 = dilate(e2, e3);
    const Triple dilated0 = dilate(opened0, opened1);
    const Triple dilated1 = dilate(opened1, opened2);
    target[w] = erode(dilated0, dilated1).word;
  }
  if (last == out.stride()) target[last - 1] &= out.last_word_mask();
}

void open_and_close(ConstBitImage in, BitImage out) {
  for (std::uint32_t r = 0; r < in.rows(); ++r) open_and_close_run(in, out, r, 0, in.stride());
}

}  // namespace plumbline
