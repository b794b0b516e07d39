#include "slicer/supports/drawing/support_painter.hpp"

#include <algorithm>
#include <bit>

#include "slicer/core/bit_spans.hpp"
#include "slicer/layers/morphology.hpp"

namespace plumbline::inline slicer {
namespace {

/// Widest half of a row that fits into a word with its middle pixel at bit kMiddle.
constexpr std::uint32_t kMostNarrow = 31;
constexpr std::uint32_t kMiddle = 32;

/// Draws a disc's rows. The two at the same distance above and below the middle one are alike, so their words are made once.
/// @param middle     the words of the disc's middle row
/// @param words_of   words_of(i, draw) calls draw(word, bits) for the words of the i-th row from the middle
/// @param ink        as in draw_struts()
template <class WordsOf, class Ink>
void draw_rows(std::uint64_t* middle, std::size_t stride, std::size_t rows, WordsOf words_of, Ink ink) {
  words_of(0, [&](std::size_t w, std::uint64_t bits) { ink(middle[w], bits); });
  std::uint64_t* above = middle;
  std::uint64_t* below = middle;
  for (std::size_t i = 1; i < rows; ++i) {
    above -= stride;
    below += stride;
    words_of(i, [&](std::size_t w, std::uint64_t bits) {
      ink(above[w], bits);
      ink(below[w], bits);
    });
  }
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
  for_each_disc_row(pitch, radius, [&](std::uint32_t dy, std::uint32_t reach) {
    rows.count = dy;
    rows.reach[dy] = static_cast<std::uint16_t>(reach);
    if (reach <= kMostNarrow) rows.narrow[dy] = ~std::uint64_t{0} >> (63 - 2 * reach) << (kMiddle - reach);
  });
  return &rows;
}

void SupportPainter::draw(std::uint32_t layer, BitImage image, BitImage touched) {
  draw_struts(layer, image, touched, [](std::uint64_t& word, std::uint64_t bits) { word |= bits; });
}

std::uint64_t SupportPainter::draw_and_count(std::uint32_t layer, BitImage image, BitImage touched) {
  std::uint64_t drawn = 0;
  draw_struts(layer, image, touched, [&drawn](std::uint64_t& word, std::uint64_t bits) {
    if (const std::uint64_t black = bits & ~word; black != 0) drawn += count_ones(black);
    word |= bits;
  });
  return drawn;
}

template <class Ink>
void SupportPainter::draw_struts(std::uint32_t layer, BitImage image, BitImage touched, Ink ink) {
  if (at_ != layer) go_to(layer);
  for (const std::uint32_t i : active_.first(active_count_)) {
    const Strut& strut = supports_->list[i];
    const StrutSection disc = section_of(strut, layer);
    draw_disc(disc, image, touched, ink);
    if (strut.lies == 0 || (strut.column0 == strut.column1 && strut.row0 == strut.row1)) continue;
    draw_disc({strut.column1, strut.row1, disc.radius}, image, touched, ink);
    for_each_band_span(supports_->pitch, strut, disc.radius, image.columns(), image.rows(),
                       [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                         draw_span(row, begin, end, image, touched, ink);
                       });
  }
}

template <class Ink>
void SupportPainter::draw_disc(const StrutSection& disc, BitImage image, BitImage touched, Ink ink) {
  const Rows* const rows = rows_of(disc.radius);
  const std::uint32_t column = disc.column;
  const std::uint32_t reach = rows == nullptr ? 0 : rows->reach[0];
  if (rows == nullptr || column < reach || column + reach >= image.columns() || disc.row < rows->count ||
      disc.row + rows->count >= image.rows()) {
    for_each_disc_span(supports_->pitch, column, disc.row, disc.radius, image.columns(), image.rows(),
                       [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                         draw_span(row, begin, end, image, touched, ink);
                       });
    return;
  }
  const std::uint32_t first = (column - reach) / 64;
  const std::uint32_t last = (column + reach) / 64;
  std::uint64_t* const middle = &image.row(disc.row)[first];
  const std::size_t count = rows->count + 1;
  if (reach > kMostNarrow) {
    const std::uint32_t at = column - first * 64;
    draw_rows(
        middle, image.stride(), count,
        [=](std::size_t i, auto draw) { for_each_word(at - rows->reach[i], at + rows->reach[i] + 1, draw); }, ink);
  } else if (const auto shift = static_cast<int>(column - kMiddle) % 64; first == last) {
    draw_rows(
        middle, image.stride(), count, [=](std::size_t i, auto draw) { draw(0, std::rotl(rows->narrow[i], shift)); },
        ink);
  } else {
    // Bit 0 of a narrow row lies in the first word, at bit `shift` of it, which is not 0.
    draw_rows(
        middle, image.stride(), count,
        [=](std::size_t i, auto draw) {
          const std::uint64_t bits = rows->narrow[i];
          draw(0, bits << shift);
          draw(1, bits >> (64 - shift));
        },
        ink);
  }
  for_each_word(disc.row - rows->count, disc.row + rows->count + 1, [&](std::uint32_t w, std::uint64_t bits) {
    for (std::uint32_t s = (column - reach) / kStripColumns; s <= (column + reach) / kStripColumns; ++s) {
      touched.row(s)[w] |= bits;
    }
  });
}

template <class Ink>
void SupportPainter::draw_span(std::uint32_t row, std::uint32_t begin, std::uint32_t end, BitImage image,
                               BitImage touched, Ink ink) {
  const auto line = image.row(row);
  for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) { ink(line[w], bits); });
  for (std::uint32_t s = begin / kStripColumns; s * kStripColumns < end; ++s) touched.set(row, s);
}

}  // namespace plumbline::inline slicer
