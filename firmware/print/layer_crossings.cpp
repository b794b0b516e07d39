#include "firmware/print/layer_crossings.hpp"

#include <algorithm>
#include <bit>

#include "firmware/pictures/job_pictures.hpp"
#include "firmware/pictures/side_pictures.hpp"

namespace plumbline {

LayerCrossings LayerCrossings::make(const PrintGrid& grid, Arena& arena) {
  LayerCrossings all;
  const std::size_t pictures = std::max(preview_picture_bytes(grid), side_pictures_bytes(grid)) +
                               2 * BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t);
  const auto first = arena.take_bottom<std::uint32_t>(std::size_t{grid.layers} + 1, "preview");
  if (!first || arena.available() <= pictures) return all;
  const auto pixel =
      arena.take_bottom<std::uint32_t>((arena.available() - pictures) / sizeof(std::uint32_t), "preview");
  if (!pixel) return all;
  all.first_ = *first;
  all.pixel_ = *pixel;
  all.first_[0] = 0;
  all.fits_ = true;
  return all;
}

void LayerCrossings::next(std::uint32_t layer, ConstBitImage mask, ConstBitImage below) {
  for (std::uint32_t r = 0; r < mask.rows() && fits_; ++r) {
    const auto now = mask.row(r);
    const auto before = below.row(r);
    for (std::size_t w = 0; w < now.size(); ++w) {
      for (std::uint64_t rest = now[w] ^ before[w]; rest != 0 && fits_; rest &= rest - 1) {
        fits_ = count_ < pixel_.size();
        if (!fits_) break;
        const auto column = static_cast<std::uint32_t>(64 * w) + static_cast<std::uint32_t>(std::countr_zero(rest));
        pixel_[count_++] = r * mask.columns() + column;
      }
    }
  }
  if (fits_) first_[layer + 1] = static_cast<std::uint32_t>(count_);
}

RRep LayerCrossings::rrep(const PrintGrid& grid) const {
  if (!fits_) return {};
  return {.grid = grid, .first = first_, .pixel = pixel_.first(count_), .is_exact = true};
}

}  // namespace plumbline
