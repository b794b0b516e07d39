#include "slicer/supports/drawing/grey_masks.hpp"

#include <algorithm>

namespace plumbline::inline slicer {

Expected<GreyMasks> GreyMasks::create(const RRep& rrep, const Supports& supports, const CureModel& model,
                                      double layer_height_mm, Arena& arena) {
  const PrintGrid& grid = rrep.grid;
  std::optional<VerticalGrey> vertical;
  std::optional<FullGrey> full;
  if (rrep.others != nullptr) {
    const auto made = FullGrey::create(rrep, supports, model, layer_height_mm, arena);
    PLUMBLINE_TRY(made);
    full = *made;
  } else {
    const auto made = VerticalGrey::create(rrep, supports, model, layer_height_mm, arena);
    PLUMBLINE_TRY(made);
    vertical = *made;
  }
  const auto runs = arena.take_bottom<GreyRun>(GreyRuns::runs_needed(grid.columns, grid.rows), "grey pixels");
  PLUMBLINE_TRY(runs);
  const auto words = arena.take_bottom<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), "masks");
  PLUMBLINE_TRY(words);
  GreyMasks masks(GreyRuns(*runs, grid.columns), BitImage(*words, grid.columns, grid.rows));
  masks.vertical_ = vertical;
  masks.full_ = full;
  return masks;
}

std::size_t GreyMasks::bytes_needed(const PrintGrid& grid, std::size_t supports, Grey grey) {
  if (grey == Grey::kOff) return 0;
  return (grey == Grey::kFull ? FullGrey::bytes_needed(grid, supports) : VerticalGrey::bytes_needed(grid, supports)) +
         Arena::rounded(GreyRuns::runs_needed(grid.columns, grid.rows) * sizeof(GreyRun)) +
         Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t));
}

ConstBitImage GreyMasks::find(std::uint32_t layer, const MaskStream& stream, ConstBitImage mask) {
  if (full_) {
    std::ranges::copy(mask.words(), image_.words().begin());
    full_->find(layer, stream.section(), mask, image_, greys_);
    return image_;
  }
  vertical_->find(layer, stream.section(), mask, greys_);
  if (greys_.empty()) return mask;
  std::ranges::copy(mask.words(), image_.words().begin());
  set_bits(greys_.runs(), image_);
  return image_;
}

}  // namespace plumbline::inline slicer
