#include "slicer/supports/drawing/support_cover.hpp"

#include <bit>
#include <utility>

#include "slicer/layers/morphology.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "grey";

std::uint32_t strips_of(std::uint32_t columns) { return (columns + kStripColumns - 1) / kStripColumns; }

}  // namespace

std::size_t SupportCover::bytes_needed(const PrintGrid& grid, std::size_t supports) {
  if (supports == 0) return 0;
  return SupportPainter::bytes_needed(supports) +
         Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         Arena::rounded(BitImage::words_needed(grid.rows, strips_of(grid.columns)) * sizeof(std::uint64_t));
}

Expected<SupportCover> SupportCover::create(const PrintGrid& grid, const Supports& supports, Arena& arena) {
  SupportCover cover;
  if (supports.empty()) return cover;
  const std::uint32_t strips = strips_of(grid.columns);
  const auto painter = SupportPainter::create(supports, arena);
  PLUMBLINE_TRY(painter);
  const auto image = arena.take_bottom<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(image);
  const auto drawn = arena.take_bottom<std::uint64_t>(BitImage::words_needed(grid.rows, strips), kStage);
  PLUMBLINE_TRY(drawn);
  cover.exists_ = true;
  cover.painter_ = *painter;
  cover.image_ = BitImage(*image, grid.columns, grid.rows);
  cover.drawn_ = BitImage(*drawn, grid.rows, strips);
  cover.image_.clear();
  cover.drawn_.clear();
  return cover;
}

void SupportCover::draw(std::uint32_t layer) {
  if (exists_) painter_.draw(layer, image_, drawn_);
}

void SupportCover::clear() {
  if (!exists_) return;
  for (std::uint32_t strip = 0; strip < drawn_.rows(); ++strip) {
    const auto groups = drawn_.row(strip);
    for (std::uint32_t g = 0; g < groups.size(); ++g) {
      for (std::uint64_t rows = std::exchange(groups[g], 0); rows != 0; rows &= rows - 1) {
        const auto row = g * 64 + static_cast<std::uint32_t>(std::countr_zero(rows));
        image_.row(row)[strip * kStripColumns / 64] = 0;
      }
    }
  }
}

}  // namespace plumbline::inline slicer
