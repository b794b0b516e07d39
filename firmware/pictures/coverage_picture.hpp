#pragma once
/// The coverage picture: which parts of the surface were scanned, and which were closed.

#include "firmware/pictures/preview/preview.hpp"
#include "slicer/rrep/confidence.hpp"

namespace plumbline::firmware::inline pictures {

/// Draws the object from the front, the back, above and below, at one scale, coloured by the evidence for each place of the
/// surface, with a legend that gives the share of each colour. As large as the preview.
/// @param rrep   at least one layer
/// @param map    not empty
/// @param name   of the scan
/// @param arena  for depths: taken from the top and released
/// @param rgb    kPageBytes of the caller, row after row from the top; overwritten
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Status draw_coverage(const RRep& rrep, const ConfidenceMap& map, std::string_view name, Arena& arena,
                                   std::span<std::uint8_t> rgb);

}  // namespace plumbline::firmware::inline pictures
