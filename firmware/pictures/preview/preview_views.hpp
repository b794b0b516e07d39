#pragma once
/// The views of the preview, for pages and for small pictures.

#include <cstddef>
#include <optional>

#include "firmware/pictures/preview/preview_layout.hpp"
#include "firmware/pictures/preview/preview_survey.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures::preview {

/// A view before it is shaded.
struct SeenView {
  const DepthMap& map;
  Side side = Side::kFront;
  Box3f box;  ///< of what is shown, print coordinates, mm
  float samples_per_mm = 1;

  /// Column, row and depth of a place of the print, in samples of the map.
  Vec3f place(const Vec3f& print_mm) const;
};

/// Colours of a view other than those of object and supports.
struct Paint {
  std::span<const Rgb> colours;                     ///< by material
  FunctionRef<void(const SeenView&)> give_colours;  ///< changes the map's materials
  std::optional<std::uint8_t> shadowless = {};      ///< of shade_depth()
};

/// Bytes that draw_views() takes from the top of the arena and releases.
std::size_t views_bytes(const PrintGrid& grid, const Page& page, Views views);

/// Draws the print on a background, from three sides or from the front.
/// @param picture  of the page's size; overwritten
/// @param paint    null: the colours of object and supports
/// @returns where the views are; nothing if there is no object
/// @retval ErrorCode::kOutOfMemory  the arena has less than views_bytes() left
[[nodiscard]] Expected<std::optional<Layout>> draw_views(const RRep& rrep, const Supports& supports, const Page& page,
                                                         Views views, Arena& arena, const Picture& picture,
                                                         const Paint* paint = nullptr);

}  // namespace plumbline::firmware::inline pictures::preview
