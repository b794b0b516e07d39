#include "slicer/supports/drawing/vertical_grey.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <utility>

#include "slicer/layers/morphology.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "grey";

/// Room between a level that cures by itself and one that does not.
constexpr double kMargin = 0.05;

bool has_white_beside(ConstBitImage mask, std::uint32_t column, std::uint32_t row) {
  return (column > 0 && mask.at(column - 1, row)) || (column + 1 < mask.columns() && mask.at(column + 1, row)) ||
         (row > 0 && mask.at(column, row - 1)) || (row + 1 < mask.rows() && mask.at(column, row + 1));
}

std::uint32_t strips_of(std::uint32_t columns) { return (columns + kStripColumns - 1) / kStripColumns; }

}  // namespace

double grey_of(const CureModel& model, double layer_height_mm, double share) {
  if (!model.is_known()) return 1 - share;
  // Light in parts of E exp(-d / Dp), which a lit layer leaves at the front, d below its film: that of the layers above the grey one.
  const double next = exponential(-layer_height_mm / model.penetration_mm);
  const double above = next / (1 - next), largest = next;
  const double rest = 1 - model.exchange;
  const double all = 1 + rest * above;
  const double needed = all * exponential(-share * layer_height_mm / model.penetration_mm);
  // The grey layer's own light is the largest, or that of the one above it is.
  const double as_largest = needed - rest * above;
  if (as_largest >= largest || rest <= 0) return std::clamp(as_largest, 0.0, 1.0);
  return std::clamp((needed - largest) / rest - above + largest, 0.0, 1.0);
}

VerticalGrey::VerticalGrey(const RRep& rrep, const CureModel& model, double layer_height_mm)
    : rrep_(&rrep), packing_(rrep.grid), first_(model.bottom_layers + model.faded_layers) {
  const double curing = model.is_known() ? model.critical_dose / model.dose * kFullLevel : kLeastCuringLevel;
  // Whoever reads the mask from a file takes what is below kLeastCuringLevel for black.
  const auto least = static_cast<std::uint8_t>(
      std::clamp(std::ceil(curing * (1 + kMargin)), double{kLeastCuringLevel}, double{kFullLevel}));
  most_alone_ = static_cast<std::uint32_t>(curing * (1 - kMargin));
  for (std::uint32_t part = 0; part < CrossingHeight::kParts; ++part) {
    // In the upper half of its layer's range a crossing is above that layer's underside, in the lower half above that of the one below.
    const double above = (part + 0.5) / CrossingHeight::kParts;
    const double share = part < CrossingHeight::kUnderside ? above + 0.5 : above - 0.5;
    levels_[part] = static_cast<std::uint8_t>(std::floor(grey_of(model, layer_height_mm, share) * kFullLevel + 0.5));
    if (part >= CrossingHeight::kUnderside) levels_[part] = std::max(levels_[part], least);
  }
}

std::size_t VerticalGrey::bytes_needed(const PrintGrid& grid, std::size_t supports) {
  if (supports == 0) return 0;
  return SupportPainter::bytes_needed(supports) +
         Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         Arena::rounded(BitImage::words_needed(grid.rows, strips_of(grid.columns)) * sizeof(std::uint64_t));
}

Expected<VerticalGrey> VerticalGrey::create(const RRep& rrep, const Supports& supports, const CureModel& model,
                                            double layer_height_mm, Arena& arena) {
  VerticalGrey grey(rrep, model, layer_height_mm);
  if (supports.empty()) return grey;
  const PrintGrid& grid = rrep.grid;
  const std::uint32_t strips = strips_of(grid.columns);
  const auto painter = SupportPainter::create(supports, arena);
  PLUMBLINE_TRY(painter);
  const auto image = arena.take_bottom<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(image);
  const auto drawn = arena.take_bottom<std::uint64_t>(BitImage::words_needed(grid.rows, strips), kStage);
  PLUMBLINE_TRY(drawn);
  grey.has_supports_ = true;
  grey.painter_ = *painter;
  grey.supports_ = BitImage(*image, grid.columns, grid.rows);
  grey.drawn_ = BitImage(*drawn, grid.rows, strips);
  grey.supports_.clear();
  grey.drawn_.clear();
  return grey;
}

void VerticalGrey::draw_supports(std::uint32_t layer) {
  if (has_supports_) painter_.draw(layer, supports_, drawn_);
}

void VerticalGrey::clear_supports() {
  if (!has_supports_) return;
  for (std::uint32_t strip = 0; strip < drawn_.rows(); ++strip) {
    const auto groups = drawn_.row(strip);
    for (std::uint32_t g = 0; g < groups.size(); ++g) {
      for (std::uint64_t rows = std::exchange(groups[g], 0); rows != 0; rows &= rows - 1) {
        const auto row = g * 64 + static_cast<std::uint32_t>(std::countr_zero(rows));
        supports_.row(row)[strip * kStripColumns / 64] = 0;
      }
    }
  }
}

void VerticalGrey::find(std::uint32_t layer, ConstBitImage section, ConstBitImage mask, GreyRuns& greys) {
  greys.clear();
  if (layer < first_) return;
  draw_supports(layer);
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
    std::uint32_t level = levels_[part];
    if (!is_grey(level)) continue;
    const std::uint32_t row = pixel / grid.columns, column = pixel % grid.columns;
    // A pixel that enters here is in the section; one that enters in the next layer is not, and no crossing of an exit is either of these.
    if (section.at(column, row) != enters_here || mask.at(column, row) != enters_here) continue;
    if (has_supports_ && supports_.at(column, row)) continue;
    if (!enters_here && level > most_alone_ && !has_white_beside(mask, column, row)) level = most_alone_;
    greys.add(pixel, static_cast<std::uint8_t>(level));
  }
  clear_supports();
}

}  // namespace plumbline::inline slicer
