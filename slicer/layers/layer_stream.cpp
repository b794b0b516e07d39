#include "slicer/layers/layer_stream.hpp"

#include <algorithm>
#include <bit>

#include "slicer/layers/morphology.hpp"

namespace plumbline {

Expected<LayerStream> LayerStream::create(const RRep& rrep, Arena& arena, const Supports* supports) {
  const std::uint32_t columns = rrep.grid.columns;
  const std::uint32_t rows = rrep.grid.rows;
  const std::uint32_t stride = (columns + 63) / 64;
  LayerStream stream;
  stream.rrep_ = &rrep;
  auto section = arena.take_bottom<std::uint64_t>(BitImage::words_needed(columns, rows), "layer stream");
  if (!section) return tl::unexpected<Error>(section.error());
  auto mask = arena.take_bottom<std::uint64_t>(BitImage::words_needed(columns, rows), "layer stream");
  if (!mask) return tl::unexpected<Error>(mask.error());
  auto changed = arena.take_bottom<std::uint64_t>(BitImage::words_needed(stride, rows), "layer stream");
  if (!changed) return tl::unexpected<Error>(changed.error());
  stream.section_ = BitImage(*section, columns, rows);
  stream.mask_ = BitImage(*mask, columns, rows);
  stream.changed_ = BitImage(*changed, stride, rows);
  stream.first_changed_ = rows;
  stream.section_.clear();
  stream.mask_.clear();
  stream.changed_.clear();
  if (supports != nullptr && !supports->empty()) {
    auto drawn = arena.take_bottom<std::uint64_t>(BitImage::words_needed(stride, rows), "layer stream");
    if (!drawn) return tl::unexpected<Error>(drawn.error());
    auto painter = SupportPainter::create(*supports, arena);
    if (!painter) return tl::unexpected<Error>(painter.error());
    stream.drawn_ = BitImage(*drawn, stride, rows);
    stream.drawn_.clear();
    stream.painter_ = *painter;
  }
  return stream;
}

std::size_t LayerStream::bytes_needed(const PrintGrid& grid, std::size_t supports) {
  const std::size_t image = BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t);
  const std::size_t changed = BitImage::words_needed((grid.columns + 63) / 64, grid.rows) * sizeof(std::uint64_t);
  const std::size_t painting = supports == 0 ? 0 : Arena::rounded(changed) + SupportPainter::bytes_needed(supports);
  return 2 * Arena::rounded(image) + Arena::rounded(changed) + painting;
}

void LayerStream::toggle(std::uint32_t layer) {
  const std::uint32_t columns = rrep_->grid.columns;
  const std::uint32_t first = rrep_->first[layer];
  const std::uint32_t last = rrep_->first[layer + 1];
  if (first == last) return;
  std::uint32_t row = rrep_->pixel[first] / columns;
  std::uint32_t row_start = row * columns;
  first_changed_ = std::min(first_changed_, row);
  end_changed_ = std::max(end_changed_, rrep_->pixel[last - 1] / columns + 1);
  for (std::uint32_t i = first; i < last; ++i) {
    const std::uint32_t pixel = rrep_->pixel[i];
    while (pixel - row_start >= columns) {  // pixels ascend: no division
      row_start += columns;
      ++row;
    }
    const std::uint32_t column = pixel - row_start;
    const std::uint32_t word = column / 64;
    const std::uint32_t bit = column % 64;
    section_.words()[std::size_t{row} * section_.stride() + word] ^= std::uint64_t{1} << bit;
    changed_.set(word, row);
    if (bit < kOpenCloseReach && word > 0) changed_.set(word - 1, row);
    if (bit >= 64 - kOpenCloseReach && word + 1 < section_.stride()) changed_.set(word + 1, row);
  }
}

void LayerStream::clean_changed() {
  static_assert(kOpenCloseReach == 2, "rows around a change that are made anew");
  const std::uint32_t rows = section_.rows();
  const std::uint32_t words = section_.stride();
  const std::uint32_t groups = changed_.stride();
  const bool with_supports = drawn_.rows() > 0;
  // Supports are drawn anywhere; without them most rows of a panel are far from any change.
  const std::uint32_t begin = with_supports ? 0 : std::max(first_changed_, 2U) - 2;
  const std::uint32_t end = with_supports ? rows : std::min(rows, end_changed_ + 2);
  for (std::uint32_t r = begin; r < end; ++r) {
    const std::uint32_t from = r < 2 ? 0 : r - 2;
    const std::uint32_t to = std::min(rows - 1, r + 2);
    for (std::uint32_t g = 0; g < groups; ++g) {
      std::uint64_t todo = 0;
      for (std::uint32_t k = from; k <= to; ++k) todo |= changed_.row(k)[g];
      if (with_supports) todo |= drawn_.row(r)[g];  // away with them; what is beside was never theirs
      if (words - g * 64 < 64) todo &= (std::uint64_t{1} << (words - g * 64)) - 1;
      while (todo != 0) {
        const auto first = static_cast<std::uint32_t>(std::countr_zero(todo));
        const auto length = static_cast<std::uint32_t>(std::countr_one(todo >> first));
        open_and_close_run(section_, mask_, r, g * 64 + first, g * 64 + first + length);
        if (first + length >= 64) break;
        todo &= ~std::uint64_t{0} << (first + length);
      }
    }
  }
  for (std::uint32_t r = first_changed_; r < end_changed_; ++r) {
    const auto line = changed_.row(r);
    std::fill(line.begin(), line.end(), 0);
  }
  first_changed_ = rows;
  end_changed_ = 0;
  drawn_.clear();
}

ConstBitImage LayerStream::mask(std::uint32_t layer) {
  if (static_cast<std::int64_t>(layer) < at_) {
    section_.clear();
    for (auto& word : changed_.words()) word = ~std::uint64_t{0};
    first_changed_ = 0;
    end_changed_ = section_.rows();
    at_ = -1;
  }
  while (at_ < static_cast<std::int64_t>(layer)) toggle(static_cast<std::uint32_t>(++at_));
  clean_changed();
  if (drawn_.rows() > 0) support_pixels_ = painter_.draw(layer, mask_, drawn_);
  return mask_;
}

}  // namespace plumbline
