#pragma once
/// Sheets that are there only because supports reach beyond the edge of what was seen.

#include <span>

#include "slicer/implicit/winding_number.hpp"
#include "slicer/rrep/ray_crossing.hpp"

namespace plumbline {

/// Off the centre of the points round it by more than this share of the reach (Intersection::off_centre) a sheet is
/// extrapolated. On the straight edge of a sampled plane it is 0.29, in a right corner 0.41; of the crossings of the suite's
/// scans 0.2 % (gear clean) to 2 % (gear dirty) have more, most of them 0.55 to 0.8.
inline constexpr float kExtrapolated = 0.4F;

/// Moves each extrapolated crossing to where the winding number of the whole cloud has the sheet, or takes it out.
///
/// Without points on all sides MLS goes on as a plane, and noise tilts it: below the rim of a vertical wall it meets rays
/// that see nothing else (Adamson and Alexa 2004 end a surface there). If the winding number knows of no sheet, solid on the
/// one side and nothing on the other, the nearest place where it changes takes its place; where there is none before the next
/// crossing, both go. Nothing is moved outwards beyond the outermost sheets of the ray.
/// @param crossings  of the ray at (x, y), mm; ascending, in turn entering and exiting. May become fewer, by pairs
/// @param reach      mm, of the supports of its points
/// @returns whether any was moved or taken out
bool settle_extrapolated(std::span<RayCrossing>& crossings, float x, float y, const WindingTree& winding, float reach);

}  // namespace plumbline
