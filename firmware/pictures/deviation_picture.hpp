#pragma once
/// The preview in the colours of how far a part's surface lies from the true one.

#include "firmware/pictures/preview/preview.hpp"
#include "slicer/core/numbers/oriented_point.hpp"

namespace plumbline::firmware::inline pictures {

/// Draws the object as draw_preview(), blue where too little is cured, white where it is true, red where it is too much, with a scale.
/// For the desktop: uses the heap.
/// @param points         of the true surface, print coordinates, mm
/// @param deviations_mm  of the same points, outwards; infinite where no surface was found
/// @retval as draw_preview()
[[nodiscard]] Status draw_deviation(const RRep& rrep, const Supports& supports, const PreviewText& text,
                                    std::span<const OrientedPoint> points, std::span<const float> deviations_mm,
                                    Arena& arena, std::span<std::uint8_t> rgb);

}  // namespace plumbline::firmware::inline pictures
