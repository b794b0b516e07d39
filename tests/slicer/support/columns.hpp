#pragma once
/// R-Reps of one row of pixels, for what happens along rays.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "slicer/core/arena.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/rrep/rrep.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {

constexpr double kColumnLayer = 0.05;  ///< mm

// Those of the profile `standard`: 3.5 mW/cm2 for 2.5 s and 30 s.
inline CureModel standard_resin() {
  return {.penetration_mm = 0.12,
          .critical_dose = 3.2,
          .exchange = 0,
          .dose = 8.75,
          .bottom_dose = 105,
          .bottom_layers = 6,
          .faded_layers = 4};
}

/// Heights of crossings in layers from the plate, of one column of pixels after the other.
inline RRep columns_of(const std::vector<std::vector<double>>& heights, std::uint32_t layers, Arena& arena) {
  const PrintGrid grid{.columns = static_cast<std::uint32_t>(heights.size()),
                       .rows = 1,
                       .layers = layers,
                       .layer_height_mm = static_cast<float>(kColumnLayer)};
  const CrossingPacking packing(grid);
  const auto first = value_of(arena.take_bottom<std::uint32_t>(layers + 1, "test"));
  std::vector<std::uint32_t> packed;
  for (std::uint32_t k = 0; k < layers; ++k) {
    first[k] = static_cast<std::uint32_t>(packed.size());
    for (std::uint32_t c = 0; c < grid.columns; ++c) {
      for (const double height : heights[c]) {
        const CrossingHeight at = height_of(static_cast<float>(height * kColumnLayer), grid);
        if (at.layer() == k) packed.push_back(packing.packed(c, at.part()));
      }
    }
  }
  first[layers] = static_cast<std::uint32_t>(packed.size());
  const auto words = value_of(arena.take_bottom<std::uint32_t>(packed.size(), "test"));
  std::ranges::copy(packed, words.begin());
  return {.grid = grid, .first = first, .packed = words, .is_exact = true};
}

}  // namespace plumbline::testing
