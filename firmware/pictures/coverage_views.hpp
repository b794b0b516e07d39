#pragma once
/// The views of the coverage picture, for pages and for small pictures.

#include <cstdint>
#include <span>

#include "firmware/pictures/preview_layout.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::preview {

/// Draws the four views on a page of the preview's size, without texts.
/// @param map    not empty
/// @param arena  for depths: taken from the top and released
/// @param rgb    3 * kPreviewColumns * kPreviewRows bytes; overwritten
/// @returns the part of the page that has the views; empty if there is no object
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<PagePart> draw_coverage_views(const RRep& rrep, const ConfidenceMap& map, Arena& arena,
                                                     std::span<std::uint8_t> rgb);

}  // namespace plumbline::preview
