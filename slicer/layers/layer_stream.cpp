#include "slicer/layers/layer_stream.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "slicer/layers/morphology.hpp"

namespace plumbline::inline slicer {
namespace {

std::uint32_t strips_of(std::uint32_t columns) { return (columns + kStripColumns - 1) / kStripColumns; }

}  // namespace

Expected<LayerStream> LayerStream::create(const RRep& rrep, Arena& arena) {
  const std::uint32_t columns = rrep.grid.columns;
  const std::uint32_t rows = rrep.grid.rows;
  const std::uint32_t strips = strips_of(columns);
  LayerStream stream;
  stream.rrep_ = &rrep;
  auto section = arena.take_bottom<std::uint64_t>(BitImage::words_needed(columns, rows), "layer stream");
  PLUMBLINE_TRY(section);
  auto mask = arena.take_bottom<std::uint64_t>(BitImage::words_needed(columns, rows), "layer stream");
  PLUMBLINE_TRY(mask);
  auto changed = arena.take_bottom<std::uint64_t>(BitImage::words_needed(rows, strips), "layer stream");
  PLUMBLINE_TRY(changed);
  stream.section_ = BitImage(*section, columns, rows);
  stream.mask_ = BitImage(*mask, columns, rows);
  stream.changed_ = BitImage(*changed, rows, strips);
  stream.row_of_ = Quotient(columns);
  stream.packing_ = CrossingPacking(rrep.grid);
  stream.section_.clear();
  stream.mask_.clear();
  stream.changed_.clear();
  return stream;
}

std::size_t LayerStream::bytes_needed(const PrintGrid& grid) {
  const std::size_t image = BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t);
  const std::size_t changed = BitImage::words_needed(grid.rows, strips_of(grid.columns)) * sizeof(std::uint64_t);
  return 2 * Arena::rounded(image) + Arena::rounded(changed);
}

void LayerStream::toggle(std::uint32_t layer) {
  const std::uint32_t columns = rrep_->grid.columns;
  const auto crossings = rrep_->packed.subspan(rrep_->first[layer], rrep_->first[layer + 1] - rrep_->first[layer]);
  const Quotient row_of = row_of_;  // copies: the stores below can't change them
  const CrossingPacking packing = packing_;
  const std::uint32_t* at = crossings.data();
  const std::uint32_t* const end = at + crossings.size();
  while (at != end) {
    std::uint32_t pixel = packing.pixel(*at);
    const std::uint32_t row = row_of(pixel);
    const std::uint32_t row_start = row * columns;
    const std::uint32_t word = (pixel - row_start) / 64;
    const std::uint32_t word_start = row_start + word * 64;
    const std::uint32_t word_columns = std::min(64U, row_start + columns - word_start);
    std::uint64_t bits = 0;
    do {
      bits |= std::uint64_t{1} << (pixel - word_start);
      if (++at == end) break;
      pixel = packing.pixel(*at);
    } while (pixel - word_start < word_columns);
    section_.row(row)[word] ^= bits;
    const std::uint32_t strip = word * 64 / kStripColumns;
    if (static_cast<std::uint32_t>(bits) != 0) changed_.set(row, strip);
    if (bits >> kStripColumns != 0) changed_.set(row, strip + 1);
  }
}

/// @param first, end  half-open range of rows that have changed in the strip
void LayerStream::remake(std::uint32_t strip, std::uint32_t first, std::uint32_t end) {
  if (!rrep_->is_exact) {
    open_and_close_rows(section_, mask_, strip, first - std::min(first, kOpenCloseReach),
                        std::min(section_.rows(), end + kOpenCloseReach));
    return;
  }
  for (std::uint32_t r = first; r < end; ++r) {
    const std::size_t word = strip * kStripColumns / 64;
    mask_.row(r)[word] = section_.row(r)[word];
  }
}

void LayerStream::remake_changed() {
  // Rows that a change affects, and those of the next changes below, are done in one go: up to this distance that takes fewer
  // rows than starting anew.
  constexpr std::uint32_t kApart = 4 * kOpenCloseReach + 1;
  for (std::uint32_t strip = 0; strip < changed_.rows(); ++strip) {
    std::uint32_t first = 0;
    std::uint32_t end = 0;  // 0: no row yet
    const auto groups = changed_.row(strip);
    for (std::uint32_t g = 0; g < groups.size(); ++g) {
      std::uint64_t group = std::exchange(groups[g], 0);
      while (group != 0) {
        const auto bit = static_cast<std::uint32_t>(std::countr_zero(group));
        const auto rows = static_cast<std::uint32_t>(std::countr_one(group >> bit));
        group &= rows == 64 ? 0 : ~(((std::uint64_t{1} << rows) - 1) << bit);
        const std::uint32_t row = g * 64 + bit;
        if (end == 0 || row - end >= kApart) {
          if (end > 0) remake(strip, first, end);
          first = row;
        }
        end = row + rows;
      }
    }
    if (end > 0) remake(strip, first, end);
  }
}

ConstBitImage LayerStream::mask(std::uint32_t layer) {
  if (static_cast<std::int64_t>(layer) < at_) {
    section_.clear();
    for (std::uint32_t strip = 0; strip < changed_.rows(); ++strip) {
      const auto groups = changed_.row(strip);
      std::fill(groups.begin(), groups.end(), ~std::uint64_t{0});
      groups.back() = changed_.last_word_mask();
    }
    at_ = -1;
  }
  while (at_ < static_cast<std::int64_t>(layer)) toggle(static_cast<std::uint32_t>(++at_));
  remake_changed();
  return mask_;
}

}  // namespace plumbline::inline slicer
