#pragma once
/// Pads below what stands on the plate with too little area.

#include <cstddef>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/strut_list.hpp"

namespace plumbline::inline slicer {

/// A region of the first layer with less than this holds less than 0.5 N on the plate (PeelSettings of hal/sim): it tears off once it has
/// grown to some mm2. It is a speck of a rough underside, or the foot of a pillar that has no room for a base.
inline constexpr double kLeastFoot_mm2 = 1;
/// Radius of the pad that it gets, which holds 1.6 N, and its height.
inline constexpr double kPadRadius_mm = 1;
inline constexpr double kPadHeight_mm = 0.3;

/// Adds a pad to each small region of the first layer, supports included. Small regions on one pad need one.
/// @param rrep   of the object as it stands
/// @param arena  for the layer and its regions, released again; a layer with more regions than there is room for gets no pads
/// @returns how many
/// @retval ErrorCode::kOutOfMemory  add_feet_bytes()
[[nodiscard]] Expected<std::uint32_t> add_feet(const RRep& rrep, StrutList& list, Arena& arena);
std::size_t add_feet_bytes(const PrintGrid& grid);

}  // namespace plumbline::inline slicer
