#pragma once
/// Changes to an R-Rep that stands.

#include <cstdint>
#include <optional>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/layers/layer_totals.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline {

/// One pixel changes its colour from `layer` upwards.
struct RRepToggle {
  std::uint32_t layer;  ///< grid.layers and above: never seen
  std::uint32_t pixel;  ///< row * columns + column
};

/// Adds crossings, and takes out those that meet one of the same layer and pixel.
/// @param rrep     the newest block at the bottom of the arena
/// @param toggles  any order, are sorted; a pair of equal ones cancels
/// @retval ErrorCode::kOutOfMemory  rrep is as before
[[nodiscard]] Status toggle_crossings(RRep& rrep, std::span<RRepToggle> toggles, Arena& arena);

/// Takes out the layers below the first one that prints something, so that the object stands on the plate, and those above
/// the last one: those that are empty, and those with nothing but what the opening of the masks takes away, such as the tip
/// of a stray.
/// @param rrep   the newest block at the bottom of the arena; as before if no layer prints anything
/// @param known  the empty layers, if a sweep has found them; else the masks at both ends are made to look
/// @returns how many there were
/// @retval ErrorCode::kOutOfMemory  for two images and the crossings of the layers below; rrep is as before
[[nodiscard]] Expected<EmptyLayers> trim_empty_layers(RRep& rrep, Arena& arena, std::optional<EmptyLayers> known = {});

}  // namespace plumbline
