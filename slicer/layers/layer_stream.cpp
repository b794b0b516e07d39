#include "slicer/layers/layer_stream.hpp"

#include <algorithm>
#include <bit>

#include "slicer/layers/morphology.hpp"

namespace plumbline {

Expected<LayerStream> LayerStream::create(const RRep& rrep, Arena& arena) {
  const std::uint32_t columns = rrep.grid.columns;
  const std::uint32_t rows = rrep.grid.rows;
  const std::uint32_t stride = (columns + 63) / 64;
  LayerStream stream;
  stream.rrep_ = &rrep;
  auto section = arena.take_bottom<std::uint64_t>(BitImage::words_needed(columns, rows), "layer stream");
  PLUMBLINE_TRY(section);
  auto mask = arena.take_bottom<std::uint64_t>(BitImage::words_needed(columns, rows), "layer stream");
  PLUMBLINE_TRY(mask);
  auto changed = arena.take_bottom<std::uint64_t>(BitImage::words_needed(stride, rows), "layer stream");
  PLUMBLINE_TRY(changed);
  stream.section_ = BitImage(*section, columns, rows);
  stream.mask_ = BitImage(*mask, columns, rows);
  stream.changed_ = BitImage(*changed, stride, rows);
  stream.first_changed_ = rows;
  stream.section_.clear();
  stream.mask_.clear();
  stream.changed_.clear();
  return stream;
}

std::size_t LayerStream::bytes_needed(const PrintGrid& grid) {
  const std::size_t image = BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t);
  const std::size_t changed = BitImage::words_needed((grid.columns + 63) / 64, grid.rows) * sizeof(std::uint64_t);
  return 2 * Arena::rounded(image) + Arena::rounded(changed);
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

void LayerStream::remake_changed() {
  static_assert(kOpenCloseReach == 2, "a change affects two rows above and below it");
  const std::uint32_t rows = section_.rows();
  const std::uint32_t words = section_.stride();
  const std::uint32_t groups = changed_.stride();
  const std::uint32_t begin = std::max(first_changed_, 2U) - 2;
  const std::uint32_t end = std::min(rows, end_changed_ + 2);
  for (std::uint32_t r = begin; r < end; ++r) {
    const std::uint32_t from = r < 2 ? 0 : r - 2;
    const std::uint32_t to = std::min(rows - 1, r + 2);
    for (std::uint32_t g = 0; g < groups; ++g) {
      std::uint64_t todo = 0;
      for (std::uint32_t k = from; k <= to; ++k) todo |= changed_.row(k)[g];
      if (words - g * 64 < 64) todo &= (std::uint64_t{1} << (words - g * 64)) - 1;
      while (todo != 0) {
        const auto first = static_cast<std::uint32_t>(std::countr_zero(todo));
        const auto length = static_cast<std::uint32_t>(std::countr_one(todo >> first));
        const std::uint32_t begin_word = g * 64 + first;
        if (rrep_->is_exact) {
          std::copy_n(section_.row(r).begin() + begin_word, length, mask_.row(r).begin() + begin_word);
        } else {
          open_and_close_run(section_, mask_, r, begin_word, begin_word + length);
        }
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
  remake_changed();
  return mask_;
}

}  // namespace plumbline
