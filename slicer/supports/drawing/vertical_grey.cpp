#include "slicer/supports/drawing/vertical_grey.hpp"

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
  const std::uint32_t columns = rrep_->grid.columns;
  ChangingRays rays(*rrep_, layer, section, levels_);
  while (rays.next()) {
    std::uint32_t level = rays.level();
    if (!is_grey(level)) continue;
    const std::uint32_t row = rays.pixel() / columns, column = rays.pixel() % columns;
    if (mask.at(column, row) != rays.is_lit() || supports_.at(column, row)) continue;
    if (!rays.is_lit() && level > levels_.most_alone && !has_white_beside(mask, column, row)) {
      level = levels_.most_alone;
    }
    greys.add(rays.pixel(), static_cast<std::uint8_t>(level));
  }
  supports_.clear();
}

}  // namespace plumbline::inline slicer
