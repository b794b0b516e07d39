#pragma once
/// Crossings that MLS has extrapolated beyond the edge of what was scanned.

#include <span>

#include "slicer/implicit/column_winding.hpp"
#include "slicer/rrep/ray_crossing.hpp"

namespace plumbline::inline slicer {

/// A crossing is extrapolated if Intersection::off_centre (a share of the reach) exceeds this. It is 0.29 on the straight edge
/// of a sampled plane and 0.41 in a right-angled corner. Of the crossings of the suite's scans 0.2 % (gear clean) to 2 % (gear
/// dirty) exceed 0.4, most of them with 0.55 to 0.8.
inline constexpr float kExtrapolated = 0.4F;

/// Removes the crossings around each hollow that is shorter than a support, if the winding number in its middle says solid.
///
/// At the foot of a thin pin the face around it has most of the points. MLS continues it through the pin, which is cut off, and then
/// left out since nothing holds it.
/// @param crossings, reach  as for settle_extrapolated()
/// @returns whether any was removed
bool fill_short_hollows(std::span<RayCrossing>& crossings, float x, float y, ColumnWinding& winding, float reach);

/// Moves each extrapolated crossing to where the winding number of the whole cloud changes, or removes it.
///
/// Without points on all sides MLS continues the surface as a plane, which noise tilts: below the rim of a vertical wall that
/// plane crosses rays that meet nothing else (Adamson and Alexa 2004 end the surface there). If the winding number is not
/// solid on one side of the crossing and empty on the other, the crossing moves to the nearest place where it changes. If there
/// is none before the next crossing, both are removed. The outermost crossings of the ray are never moved outwards.
/// @param crossings  of the ray at (x, y), mm; ascending, alternately entering and exiting. Shrinks by pairs
/// @param reach      largest support radius of its points, mm
/// @returns whether any crossing was moved or removed
bool settle_extrapolated(std::span<RayCrossing>& crossings, float x, float y, ColumnWinding& winding, float reach);

}  // namespace plumbline::inline slicer
