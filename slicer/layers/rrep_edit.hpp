#pragma once
/// Edits a finished R-Rep.

#include <compare>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/layers/layer_totals.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// A pixel changes its colour from `layer` upwards.
struct RRepToggle {
  std::uint32_t layer;  ///< grid.layers or more: no effect
  std::uint32_t pixel;  ///< row * columns + column
  auto operator<=>(const RRepToggle&) const = default;
};

/// Adds crossings at the undersides of layers; one that meets a crossing of the same layer and pixel cancels it.
/// @param rrep     the newest block at the bottom of the arena
/// @param toggles  in any order; sorted in place; equal pairs cancel
/// @retval ErrorCode::kOutOfMemory  rrep is unchanged
[[nodiscard]] Status toggle_crossings(RRep& rrep, std::span<RRepToggle> toggles, Arena& arena);

/// Counts the layers at both ends whose masks are empty.
/// @retval ErrorCode::kOutOfMemory  no room for two images at the bottom of the arena
[[nodiscard]] Expected<EmptyLayers> find_empty_layers(const RRep& rrep, Arena& arena);

/// Removes the layers at both ends whose masks are empty, so that the object stands on the plate. A layer with nothing but
/// what opening removes, such as the tip of an outlier, counts as empty.
/// @param rrep   the newest block at the bottom of the arena
/// @param known  the empty layers, if a sweep has found them; otherwise the masks at both ends are made and searched
/// @returns how many layers were removed
/// @retval ErrorCode::kNoSurface    all masks are empty; rrep is unchanged
/// @retval ErrorCode::kOutOfMemory  no room for two images and the crossings below; rrep is unchanged
[[nodiscard]] Expected<EmptyLayers> trim_empty_layers(RRep& rrep, Arena& arena, std::optional<EmptyLayers> known = {});

/// Removes layers at both ends, whatever they hold: what goes on above those below begins in the first layer that stays. Needs no memory and frees none.
/// @param cut  fewer layers than `rrep` has
void cut_layers(RRep& rrep, const EmptyLayers& cut);

/// Puts `layers` empty layers below the object. Takes a new RRep::first from the bottom of the arena; the crossings stay.
/// @param layers  at most PrintGrid::kMaxLayers with those of `rrep`
/// @retval ErrorCode::kOutOfMemory  rrep is unchanged
[[nodiscard]] Status raise_object(RRep& rrep, std::uint32_t layers, Arena& arena);

}  // namespace plumbline::inline slicer
