#pragma once
/// The views of the preview, for pages and for small pictures.

#include <cstddef>
#include <optional>

#include "firmware/pictures/preview/preview_layout.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures::preview {

/// Bytes that draw_views() takes from the top of the arena and releases.
std::size_t views_bytes(const PrintGrid& grid, const Page& page, Views views);

/// Draws the print on a background, from three sides or from the front.
/// @param picture  of the page's size; overwritten
/// @returns where the views are; nothing if there is no object
/// @retval ErrorCode::kOutOfMemory  the arena has less than views_bytes() left
[[nodiscard]] Expected<std::optional<Layout>> draw_views(const RRep& rrep, const Supports& supports, const Page& page,
                                                         Views views, Arena& arena, const Picture& picture);

}  // namespace plumbline::firmware::inline pictures::preview
