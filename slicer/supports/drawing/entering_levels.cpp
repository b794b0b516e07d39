#include "slicer/supports/drawing/entering_levels.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

/// Room between a level that cures by itself and one that does not.
constexpr double kMargin = 0.05;

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

EnteringLevels::EnteringLevels(const CureModel& model, double layer_height_mm) {
  const double curing = model.is_known() ? model.critical_dose / model.dose * kFullLevel : kLeastCuringLevel;
  // Whoever reads the mask from a file takes what is below kLeastCuringLevel for black.
  least = static_cast<std::uint32_t>(
      std::clamp(std::ceil(curing * (1 + kMargin)), double{kLeastCuringLevel}, double{kFullLevel}));
  const double least_curing = model.most_dose > model.dose ? curing * model.dose / model.most_dose : curing;
  most_alone = static_cast<std::uint32_t>(least_curing * (1 - kMargin));
  for (std::uint32_t part = 0; part < CrossingHeight::kParts; ++part) {
    // In the upper half of its layer's range a crossing is above that layer's underside, in the lower half above that of the one below.
    const double above = (part + 0.5) / CrossingHeight::kParts;
    const double share = part < CrossingHeight::kUnderside ? above + 0.5 : above - 0.5;
    by_part[part] = static_cast<std::uint8_t>(std::floor(grey_of(model, layer_height_mm, share) * kFullLevel + 0.5));
    if (part >= CrossingHeight::kUnderside) by_part[part] = std::max(by_part[part], static_cast<std::uint8_t>(least));
  }
}

}  // namespace plumbline::inline slicer
