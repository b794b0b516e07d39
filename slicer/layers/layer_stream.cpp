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
  const auto crossings = rrep_->pixel.subspan(rrep_->first[layer], rrep_->first[layer + 1] - rrep_->first[layer]);
  if (crossings.empty()) return;
  std::uint32_t row = crossings.front() / columns;
  std::uint32_t row_start = row * columns;
  first_changed_ = std::min(first_changed_, row);
  end_changed_ = std::max(end_changed_, crossings.back() / columns + 1);
  for (std::size_t i = 0; i < crossings.size();) {
    while (crossings[i] - row_start >= columns) {  // pixels ascend: no division
      row_start += columns;
      ++row;
    }
    const std::uint32_t word = (crossings[i] - row_start) / 64;
    const std::uint32_t word_start = row_start + word * 64;
    const std::uint32_t word_end = std::min(word_start + 64, row_start + columns);
    std::uint64_t bits = 0;
    const std::size_t rest = word_end - crossings[i];
    if (i + rest <= crossings.size() && crossings[i + rest - 1] == word_end - 1) {  // all that are left of the word
      bits = ~std::uint64_t{0} >> (64 - rest) << (crossings[i] - word_start);
      i += rest;
    } else {
      do {
        bits |= std::uint64_t{1} << (crossings[i++] - word_start);
      } while (i < crossings.size() && crossings[i] < word_end);
    }
    section_.row(row)[word] ^= bits;
    changed_.set(word, row);
    constexpr std::uint64_t kFirst = (1U << kOpenCloseReach) - 1;
    if ((bits & kFirst) != 0 && word > 0) changed_.set(word - 1, row);
    if ((bits & kFirst << (64 - kOpenCloseReach)) != 0 && word + 1 < section_.stride()) changed_.set(word + 1, row);
  }
}

/// @param row  changed_ has the word's bit
void LayerStream::remake(std::uint32_t word, std::uint32_t row) {
  // Rows that a change affects, and those of the next change below, are done in one go if they meet.
  constexpr std::uint32_t kApart = 2 * kOpenCloseReach + 1;
  const std::uint32_t first = row;
  std::uint32_t last = row;
  for (; row < end_changed_ && row - last <= kApart; ++row) {
    std::uint64_t& group = changed_.row(row)[word / 64];
    const std::uint64_t bit = std::uint64_t{1} << (word % 64);
    if ((group & bit) == 0) continue;
    group ^= bit;
    last = row;
  }
  if (rrep_->is_exact) {
    for (std::uint32_t r = first; r <= last; ++r) mask_.row(r)[word] = section_.row(r)[word];
  } else {
    open_and_close_rows(section_, mask_, word, first - std::min(first, kOpenCloseReach),
                        std::min(section_.rows(), last + kOpenCloseReach + 1));
  }
}

void LayerStream::remake_changed() {
  for (std::uint32_t r = first_changed_; r < end_changed_; ++r) {
    const auto groups = changed_.row(r);
    for (std::uint32_t g = 0; g < groups.size(); ++g) {
      while (groups[g] != 0) remake(g * 64 + static_cast<std::uint32_t>(std::countr_zero(groups[g])), r);
    }
  }
  first_changed_ = section_.rows();
  end_changed_ = 0;
}

ConstBitImage LayerStream::mask(std::uint32_t layer) {
  if (static_cast<std::int64_t>(layer) < at_) {
    section_.clear();
    for (std::uint32_t r = 0; r < changed_.rows(); ++r) {
      const auto groups = changed_.row(r);
      std::fill(groups.begin(), groups.end(), ~std::uint64_t{0});
      groups.back() = changed_.last_word_mask();
    }
    first_changed_ = 0;
    end_changed_ = section_.rows();
    at_ = -1;
  }
  while (at_ < static_cast<std::int64_t>(layer)) toggle(static_cast<std::uint32_t>(++at_));
  remake_changed();
  return mask_;
}

}  // namespace plumbline
