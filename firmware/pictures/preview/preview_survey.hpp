#pragma once
/// The depth maps that the views of the preview are shaded from.

#include <algorithm>
#include <cstdint>
#include <span>

#include "firmware/pictures/preview/preview.hpp"
#include "firmware/pictures/preview/preview_layout.hpp"
#include "firmware/pictures/preview/preview_shading.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures::preview {

/// Pixels from one cell of the map of highest surfaces to the next, a power of two.
std::uint32_t height_step(const PrintGrid& grid);
/// Cells of that map.
std::size_t height_cells(const PrintGrid& grid);

/// The caller's memory for a survey.
struct SurveyScratch {
  std::span<std::uint64_t> section;   ///< an image of the grid
  std::span<std::uint32_t> nearest;   ///< as many as the longer side of the grid has pixels
  std::span<std::uint32_t> seen;      ///< the same
  std::span<std::uint16_t> heights;   ///< height_cells(), for the view from above
  std::span<std::uint8_t> materials;  ///< as many as heights; of the others, as many as nearest
};

enum class Side : std::uint8_t { kFront, kSide, kTop };

/// Fills the depth map of one view in a sweep over the layers.
void survey(const RRep& rrep, const Supports& supports, const Extent& extent, const Layout& layout,
            const SurveyScratch& scratch, Side side, const DepthMap& map);

}  // namespace plumbline::firmware::inline pictures::preview
