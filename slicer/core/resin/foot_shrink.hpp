#pragma once
/// Compensation of elephant's foot: the outlines of the bottom layers are moved inwards.

#include <cmath>
#include <cstdint>

namespace plumbline::inline slicer {

/// How far the fade between bottom layers and all others has come: 0 on the bottom layers, 1 after the faded ones.
constexpr double bottom_fade(std::uint32_t layer, std::uint32_t bottom_layers, std::uint32_t faded_layers) {
  if (layer < bottom_layers) return 0;
  const std::uint32_t step = layer - bottom_layers + 1;
  return step > faded_layers ? 1 : static_cast<double>(step) / (faded_layers + 1.0);
}

struct FootShrink {
  double mm = 0;  ///< on the bottom layers, less over the faded ones
  std::uint32_t bottom_layers = 0, faded_layers = 0;

  /// Whole pixels by which the outline of a layer is moved.
  std::uint32_t steps(std::uint32_t layer, double pitch_x_mm, double pitch_y_mm) const {
    return static_cast<std::uint32_t>(
        std::lround(mm * (1 - bottom_fade(layer, bottom_layers, faded_layers)) / ((pitch_x_mm + pitch_y_mm) / 2)));
  }
};

}  // namespace plumbline::inline slicer
