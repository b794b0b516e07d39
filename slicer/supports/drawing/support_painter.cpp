#include "slicer/supports/drawing/support_painter.hpp"

#include <algorithm>
#include <bit>

#include "slicer/layers/morphology.hpp"

namespace plumbline {

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
  // Few of a disc's pixels are white already: these are subtracted.
  drawn = rows->pixels;
  const auto draw_word = [&](std::uint64_t& word, std::uint64_t bits) {
    if ((word & bits) != 0) drawn -= static_cast<std::uint64_t>(std::popcount(word & bits));
    word |= bits;
  };
  const std::uint32_t first = disc.column - reach;
  const std::uint32_t last = disc.column + reach;
  const std::size_t stride = image.stride();
  const auto for_each_row = [&](auto draw_row) {
    std::uint64_t* const middle = image.row(disc.row).data();
    draw_row(middle, reach);
    for (std::size_t dy = 1; dy <= rows->count; ++dy) {
      draw_row(middle - dy * stride, rows->reach[dy]);
      draw_row(middle + dy * stride, rows->reach[dy]);
    }
  };
  if (first / 64 == last / 64) {
    for_each_row([&](std::uint64_t* line, std::uint32_t half) {
      draw_word(line[first / 64], ~std::uint64_t{0} >> (63 - 2 * half) << (disc.column % 64 - half));
    });
  } else {
    for_each_row([&](std::uint64_t* line, std::uint32_t half) {
      for_each_word(disc.column - half, disc.column + half + 1,
                    [&](std::uint32_t w, std::uint64_t bits) { draw_word(line[w], bits); });
    });
  }
  for (std::uint32_t s = first / kStripColumns; s <= last / kStripColumns; ++s) {
    const auto drawn_rows = touched.row(s);
    for_each_word(disc.row - rows->count, disc.row + rows->count + 1,
                  [&](std::uint32_t w, std::uint64_t bits) { drawn_rows[w] |= bits; });
  }
  return drawn;
}

std::uint64_t SupportPainter::draw_span(std::uint32_t row, std::uint32_t begin, std::uint32_t end, BitImage image,
                                        BitImage touched) {
  std::uint64_t drawn = 0;
  const auto line = image.row(row);
  for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) {
    bits &= ~line[w];
    if (bits == 0) return;
    drawn += static_cast<std::uint64_t>(std::popcount(bits));
    line[w] |= bits;
  });
  for (std::uint32_t s = begin / kStripColumns; s * kStripColumns < end; ++s) touched.set(row, s);
  return drawn;
}

}  // namespace plumbline
