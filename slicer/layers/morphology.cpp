#include "slicer/layers/morphology.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace plumbline::inline slicer {
namespace {

static_assert(std::endian::native == std::endian::little, "bytes of a row are taken as eight columns each, in order");

/// 64 columns of an image around a strip: where they begin in a row, and which of them are results.
class ColumnWindow {
 public:
  ColumnWindow(ConstBitImage image, std::uint32_t strip) {
    constexpr std::uint32_t kBeside = (64 - kStripColumns) / 2;
    static_assert(kBeside % 8 == 0 && kBeside >= 2 * kOpenCloseReach);
    const std::uint32_t first = strip * kStripColumns;
    const std::uint32_t last_begin = 64 * (image.stride() - 1);
    // The first window begins with the row, the last one reaches beyond its end: `beyond_` columns.
    const std::uint32_t begin = first < kBeside ? 0 : first - kBeside;
    byte_ = std::min(begin, last_begin) / 8;
    beyond_ = begin - std::min(begin, last_begin);
    const std::uint32_t before = first - begin;
    const std::uint32_t reach = std::min(before, kOpenCloseReach);
    const std::uint32_t columns = std::min(reach + kStripColumns + kOpenCloseReach, image.columns() - (first - reach));
    results_ = ~std::uint64_t{0} >> (64 - columns) << (before - reach);
  }

  std::uint64_t load(const std::uint64_t* row) const {
    std::uint64_t columns = 0;
    std::memcpy(&columns, reinterpret_cast<const std::byte*>(row) + byte_, sizeof columns);
    return columns >> beyond_;
  }
  void store(std::uint64_t* row, std::uint64_t columns) const {
    std::byte* const at = reinterpret_cast<std::byte*>(row) + byte_;
    std::uint64_t others = 0;
    std::memcpy(&others, at, sizeof others);
    others ^= (others ^ columns << beyond_) & results_ << beyond_;
    std::memcpy(at, &others, sizeof others);
  }

 private:
  std::uint32_t byte_ = 0;
  std::uint32_t beyond_ = 0;
  std::uint64_t results_ = 0;
};

/// Two rows, one below the other.
using RowPair = std::uint64_t __attribute__((vector_size(16)));

/// Of two pairs, one below the other: the row above each of the lower pair's.
RowPair above(RowPair upper, RowPair lower) { return RowPair{upper[1], lower[0]}; }

/// White where the pixel, the next one and the two below them are white.
RowPair erode(RowPair rows, RowPair below) {
  const RowPair both = rows & below;
  return both & both >> 1;
}
/// White where the pixel, the one before or one of the two above them is white.
RowPair dilate(RowPair above, RowPair rows) {
  const RowPair either = above | rows;
  return either | either << 1;
}

/// What the rows so far leave for the next two.
struct OpenAndClose {
  RowPair rows = {};     // of the image
  RowPair eroded = {};   // of its opening, half done; a row behind
  RowPair opened = {};   // of its opening; a row behind
  RowPair dilated = {};  // of its closing, half done; a row behind

  /// @returns the results of the rows kOpenCloseReach above
  RowPair operator()(RowPair next) {
    const RowPair next_eroded = erode(above(rows, next), next);
    const RowPair next_opened = dilate(above(eroded, next_eroded), next_eroded);
    const RowPair next_dilated = dilate(above(opened, next_opened), next_opened);
    const RowPair result = erode(above(dilated, next_dilated), next_dilated);
    *this = {next, next_eroded, next_opened, next_dilated};
    return result;
  }
};

}  // namespace

void open_and_close_rows(ConstBitImage in, BitImage out, std::uint32_t strip, std::uint32_t first, std::uint32_t last) {
  if (strip * kStripColumns >= in.columns()) return;
  constexpr std::uint32_t kReach = kOpenCloseReach;
  static_assert(kReach == 2, "the results of two rows are known when the next two have been seen");
  const ColumnWindow window(in, strip);
  const std::size_t stride = in.stride();
  const auto load = [&](std::uint32_t row) {  // rows outside of the image are black, as are all before the first one
    return row < in.rows() ? window.load(in.words().data() + row * stride) : 0;
  };
  OpenAndClose next;
  if (first >= kReach) next(RowPair{load(first - 2), load(first - 1)});
  if (first == 1) next(RowPair{0, load(0)});
  next(RowPair{load(first), load(first + 1)});
  std::uint32_t row = first;
  std::uint64_t* to = out.words().data() + first * stride;
  for (const std::uint64_t* from = in.words().data() + (first + 2) * stride; row + 3 < std::min(last + 2, in.rows());
       row += 2, from += 2 * stride, to += 2 * stride) {
    const RowPair result = next(RowPair{window.load(from), window.load(from + stride)});
    window.store(to, result[0]);
    window.store(to + stride, result[1]);
  }
  for (; row < last; row += 2, to += 2 * stride) {
    const RowPair result = next(RowPair{load(row + 2), load(row + 3)});
    window.store(to, result[0]);
    if (row + 1 < last) window.store(to + stride, result[1]);
  }
}

}  // namespace plumbline::inline slicer
