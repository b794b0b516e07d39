#pragma once
/// How deep the light of a print's layers cures: Jacobs' working curve (1992), with the doses of all layers that reach a place.

#include <array>
#include <cstdint>

#include "slicer/core/resin/bottom_fade.hpp"
#include "slicer/core/resin/layer_steps.hpp"

namespace plumbline::inline slicer {

/// Light enters a layer at its film, and falls to 1/e of its dose in each penetration depth on its way towards the plate:
///
///   D(z) = sum over layers k whose film z_k = (k + 1) layer_height is not below z of E_k exp(-(z_k - z) / Dp)
///
/// Resin is cured where D >= Ec. With an exchange of resin below 1, that share of the doses but the largest counts.
struct CureModel {
  double penetration_mm = 0;  ///< Dp; 0: not known
  double critical_dose = 0;   ///< Ec, mJ/cm2
  double exchange = 0;        ///< of resin by a lift: 0 doses of layers add up, 1 only the largest counts
  double dose = 0;            ///< mJ/cm2, of a layer after the faded ones
  double bottom_dose = 0;     ///< mJ/cm2, of a bottom layer
  double most_dose = 0;       ///< mJ/cm2, of the highest layers of an adaptive print; 0: `dose`
  std::uint32_t bottom_layers = 0, faded_layers = 0;  ///< of the print
  double layer_height_mm = 0;                         ///< of a layer that gets these doses; counts in adaptive prints

  bool is_known() const { return penetration_mm > 0 && critical_dose > 0 && dose > critical_dose; }
  double dose_of(std::uint32_t layer) const {
    return bottom_dose + (dose - bottom_dose) * bottom_fade(layer, bottom_layers, faded_layers);
  }
};

/// e^x for -700 <= x <= 700. Uses no function of a library, so it is the same everywhere.
double exponential(double x);

/// What the dose of a layer is multiplied by if it is `higher_mm` higher than the layer that the dose is for: so both cure as far beyond themselves.
/// By Jacobs' working curve exp(higher / Dp). The same everywhere.
/// @param penetration_mm  Dp, above 0
double dose_factor(double higher_mm, double penetration_mm);

/// The depth to which a stack of layers cures below them.
class CureDepths {
 public:
  static constexpr std::uint32_t kThick = UINT32_MAX;  ///< a count of layers: all above

  /// @param layer_height_mm  of the R-Rep
  /// @param steps            layers of the print
  CureDepths(const CureModel& model, double layer_height_mm, const LayerSteps& steps = {});

  /// Where a pixel's ray is cured if it is lit in the print's layers from `first` to `first + count - 1`, but in none below, mm below the film of
  /// the first. Uses no function of a library but +, -, * and /, so it is the same everywhere.
  double below_film_mm(std::uint32_t first, std::uint32_t count) const {
    if (count == 0) return 0;
    if (!steps_.all_one()) return adaptive_depth_mm(first, count);
    const bool is_thick = count == kThick || (count > kTabled && ends_);
    const bool is_tabled = (first >= normal_ || first < kTabledFirst) && (count <= kTabled || is_thick);
    if (!is_tabled) return depth_mm(first, count);
    return table_[first >= normal_ ? kTabledFirst : first][is_thick ? kTabled : count - 1];
  }

  const LayerSteps& steps() const { return steps_; }

 private:
  // Usual prints have 13 bottom and faded layers. In a clear resin, Dp 0.35 mm, a ten-thousandth of the light is left below 64 layers of 50 um.
  static constexpr std::uint32_t kTabledFirst = 32, kTabled = 64;

  double part_left(std::uint32_t layers) const;
  double depth_mm(std::uint32_t first, std::uint32_t count) const;
  double adaptive_depth_mm(std::uint32_t first, std::uint32_t count) const;
  double depth_of(double sum, double largest) const;

  CureModel model_;
  LayerSteps steps_;
  double per_layer_;      ///< what is left of a dose one layer deeper is e to the power of this,
  double next_;           ///< and that
  std::uint32_t normal_;  ///< the first layer above the faded ones
  bool ends_ = false;     ///< nothing of a layer's light is left kTabled layers below
  /// For `first` and `count` - 1; the last of each: above the faded layers, and of a thick part.
  std::array<std::array<double, kTabled + 1>, kTabledFirst + 1> table_ = {};
  // Of a layer of so many steps: what its dose is multiplied by, and what is left of a dose below it. Only of an adaptive print.
  std::array<double, LayerSteps::kMostStep + 1> factor_ = {}, left_ = {};
};

}  // namespace plumbline::inline slicer
