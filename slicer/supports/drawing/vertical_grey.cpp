#include "slicer/supports/drawing/vertical_grey.hpp"

#include <algorithm>
#include <span>

namespace plumbline::inline slicer {

Expected<VerticalGrey> VerticalGrey::create(const RRep& rrep, const Supports& supports, const CureModel& model,
                                            double layer_height_mm, Arena& arena) {
  const auto cover = SupportCover::create(rrep.grid, supports, arena);
  PLUMBLINE_TRY(cover);
  return VerticalGrey(rrep, model, layer_height_mm, *cover);
}

void VerticalGrey::find(std::uint32_t layer, ConstBitImage section, ConstBitImage mask, GreyRuns& greys) {
  greys.clear();
  if (layer < first_) return;
  supports_.draw(layer);
  const PrintGrid& grid = rrep_->grid;
  const auto bucket = [&](std::uint32_t k) {
    return k < grid.layers ? rrep_->packed.subspan(rrep_->first[k], rrep_->first[k + 1] - rrep_->first[k])
                           : std::span<const std::uint32_t>();
  };
  const auto own = bucket(layer), next = bucket(layer + 1);
  std::size_t i = 0, j = 0;
  while (i < own.size() || j < next.size()) {
    const std::uint32_t own_pixel = i < own.size() ? packing_.pixel(own[i]) : UINT32_MAX;
    const std::uint32_t next_pixel = j < next.size() ? packing_.pixel(next[j]) : UINT32_MAX;
    const std::uint32_t pixel = std::min(own_pixel, next_pixel);
    // What is in this layer alone stays white.
    const bool is_alone = own_pixel == next_pixel;
    const std::uint32_t crossing = own_pixel == pixel ? own[i] : next[j];
    const bool enters_here = own_pixel == pixel;
    i += own_pixel == pixel ? 1 : 0;
    j += next_pixel == pixel ? 1 : 0;
    const std::uint32_t part = packing_.height(crossing, 0).part();
    if (is_alone || enters_here != (part >= CrossingHeight::kUnderside)) continue;
    std::uint32_t level = levels_.by_part[part];
    if (!is_grey(level)) continue;
    const std::uint32_t row = pixel / grid.columns, column = pixel % grid.columns;
    // A pixel that enters here is in the section; one that enters in the next layer is not, and no crossing of an exit is either of these.
    if (section.at(column, row) != enters_here || mask.at(column, row) != enters_here) continue;
    if (supports_.at(column, row)) continue;
    if (!enters_here && level > levels_.most_alone && !has_white_beside(mask, column, row)) level = levels_.most_alone;
    greys.add(pixel, static_cast<std::uint8_t>(level));
  }
  supports_.clear();
}

}  // namespace plumbline::inline slicer
