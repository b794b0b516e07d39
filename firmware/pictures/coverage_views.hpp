#pragma once
/// The views of the coverage picture, for pages and for small pictures.

#include "firmware/pictures/preview/preview_layout.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::firmware::inline pictures::preview {

/// Draws the print on a background, from the front, the back, above and below.
/// @param map      not empty
/// @param named    whether the views' names stand below the page's area
/// @param arena    for depths: taken from the top and released
/// @param picture  of the page's size; overwritten
/// @returns the part of the page that has the views, with a rim; empty if there is no object
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<PagePart> draw_coverage_views(const RRep& rrep, const ConfidenceMap& map, const Page& page,
                                                     bool named, Arena& arena, const Picture& picture);

}  // namespace plumbline::firmware::inline pictures::preview
