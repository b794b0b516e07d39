#pragma once

#include <cstdint>

namespace plumbline::inline slicer {

/// How far the fade between bottom layers and all others has come: 0 on the bottom layers, 1 after the faded ones.
constexpr double bottom_fade(std::uint32_t layer, std::uint32_t bottom_layers, std::uint32_t faded_layers) {
  if (layer < bottom_layers) return 0;
  const std::uint32_t step = layer - bottom_layers + 1;
  return step > faded_layers ? 1 : static_cast<double>(step) / (faded_layers + 1.0);
}

}  // namespace plumbline::inline slicer
