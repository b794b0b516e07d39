#include "slicer/supports/drawing/support_painter.hpp"

#include <algorithm>

#include "slicer/layers/morphology.hpp"

namespace plumbline {
namespace {

/// Draws a disc's part of a column of words.
/// @param middle   the word in the disc's middle row
/// @param reach    of the disc's rows, from the middle one on
/// @param bits_of  bits_of(reach): the pixels of a row in these words
/// @returns how many of them were white already: few of a disc's pixels are
template <class BitsOf>
std::uint64_t draw_words(std::uint64_t* middle, std::size_t stride, std::span<const std::uint16_t> reach,
                         BitsOf bits_of) {
  std::uint64_t white = 0;
  const auto draw = [&white](std::uint64_t& word, std::uint64_t bits) {
    const std::uint64_t before = word & bits;
    word |= bits;
    if (before != 0) white += count_ones(before);
  };
  draw(*middle, bits_of(reach.front()));
  std::uint64_t* above = middle;
  std::uint64_t* below = middle;
  for (const std::uint32_t half : reach.subspan(1)) {
    const std::uint64_t bits = bits_of(half);
    draw(*(above -= stride), bits);
    draw(*(below += stride), bits);
  }
  return white;
}

/// The pixels of columns [begin, end] in word `w` of a row; may be none.
std::uint64_t bits_in_word(std::uint32_t w, std::uint32_t begin, std::uint32_t end) {
  const std::uint32_t from = std::max(begin, w * 64);
  const std::uint32_t to = std::min(end, w * 64 + 63);
  return from > to ? 0 : ~std::uint64_t{0} << (from % 64) & ~std::uint64_t{0} >> (63 - to % 64);
}

}  // namespace

Expected<SupportPainter> SupportPainter::create(const Supports& supports, Arena& arena) {
  auto active = arena.take_bottom<std::uint32_t>(supports.list.size(), "layer stream");
  PLUMBLINE_TRY(active);
  SupportPainter painter;
  painter.supports_ = &supports;
  painter.active_ = *active;
  return painter;
}

void SupportPainter::go_to(std::uint32_t layer) {
  const auto list = supports_->list;
  if (at_ + 1 != layer) {
    active_count_ = 0;
    next_ = 0;
  }
  const auto active = active_.first(active_count_);
  const auto ended =
      std::remove_if(active.begin(), active.end(), [&](std::uint32_t i) { return list[i].end <= layer; });
  active_count_ = static_cast<std::size_t>(ended - active.begin());
  for (; next_ < list.size() && list[next_].first <= layer; ++next_) {
    if (list[next_].is_in(layer)) active_[active_count_++] = static_cast<std::uint32_t>(next_);
  }
  at_ = layer;
}

/// @returns nullptr if there are too many
const SupportPainter::Rows* SupportPainter::rows_of(Nanometres radius) {
  const PixelPitch& pitch = supports_->pitch;
  Rows& rows = rows_[static_cast<std::size_t>(radius / 1000) % rows_.size()];
  if (rows.radius == radius) return &rows;
  if (radius / pitch.y > Rows::kMost) return nullptr;
  rows.radius = radius;
  rows.pixels = 0;
  for_each_disc_row(pitch, radius, [&](std::uint32_t dy, std::uint32_t reach) {
    rows.count = dy;
    rows.reach[dy] = static_cast<std::uint16_t>(reach);
    rows.pixels += (dy == 0 ? 1 : 2) * (2 * reach + 1);
  });
  return &rows;
}

std::uint64_t SupportPainter::draw(std::uint32_t layer, BitImage image, BitImage touched) {
  if (at_ != layer) go_to(layer);
  std::uint64_t drawn = 0;
  for (const std::uint32_t i : active_.first(active_count_)) {
    const Strut& strut = supports_->list[i];
    const StrutSection disc = section_of(strut, layer);
    drawn += draw_disc(disc, image, touched);
    if (strut.lies == 0 || (strut.column0 == strut.column1 && strut.row0 == strut.row1)) continue;
    drawn += draw_disc({strut.column1, strut.row1, disc.radius}, image, touched);
    for_each_band_span(supports_->pitch, strut, disc.radius, image.columns(), image.rows(),
                       [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                         drawn += draw_span(row, begin, end, image, touched);
                       });
  }
  return drawn;
}

std::uint64_t SupportPainter::draw_disc(const StrutSection& disc, BitImage image, BitImage touched) {
  const Rows* const rows = rows_of(disc.radius);
  const std::uint32_t reach = rows == nullptr ? 0 : rows->reach[0];
  std::uint64_t drawn = 0;
  if (rows == nullptr || disc.column < reach || disc.column + reach >= image.columns() || disc.row < rows->count ||
      disc.row + rows->count >= image.rows()) {
    for_each_disc_span(supports_->pitch, disc.column, disc.row, disc.radius, image.columns(), image.rows(),
                       [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                         drawn += draw_span(row, begin, end, image, touched);
                       });
    return drawn;
  }
  const std::uint32_t column = disc.column;
  const std::uint32_t first = (column - reach) / 64;
  const std::uint32_t last = (column + reach) / 64;
  const std::span<const std::uint16_t> halves(rows->reach.data(), rows->count + 1);
  const auto draw_column = [&](std::uint32_t w, auto bits_of) {
    return draw_words(&image.row(disc.row)[w], image.stride(), halves, bits_of);
  };
  drawn = rows->pixels;
  if (first == last) {
    const std::uint32_t middle = column % 64;
    drawn -= draw_column(
        first, [middle](std::uint32_t half) { return ~std::uint64_t{0} >> (63 - 2 * half) << (middle - half); });
  } else {
    for (std::uint32_t w = first; w <= last; ++w) {
      drawn -=
          draw_column(w, [w, column](std::uint32_t half) { return bits_in_word(w, column - half, column + half); });
    }
  }
  for_each_word(disc.row - rows->count, disc.row + rows->count + 1, [&](std::uint32_t w, std::uint64_t bits) {
    for (std::uint32_t s = (column - reach) / kStripColumns; s <= (column + reach) / kStripColumns; ++s) {
      touched.row(s)[w] |= bits;
    }
  });
  return drawn;
}

std::uint64_t SupportPainter::draw_span(std::uint32_t row, std::uint32_t begin, std::uint32_t end, BitImage image,
                                        BitImage touched) {
  std::uint64_t drawn = 0;
  const auto line = image.row(row);
  for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) {
    bits &= ~line[w];
    if (bits == 0) return;
    drawn += count_ones(bits);
    line[w] |= bits;
  });
  for (std::uint32_t s = begin / kStripColumns; s * kStripColumns < end; ++s) touched.set(row, s);
  return drawn;
}

}  // namespace plumbline
