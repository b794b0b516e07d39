#pragma once
/// Where the views of the preview go, and the depth maps that they are shaded from.

#include <algorithm>
#include <cstdint>
#include <span>

#include "firmware/pictures/preview.hpp"
#include "firmware/pictures/preview_shading.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/supports.hpp"

namespace plumbline::preview {

// The page, in pixels.
inline constexpr std::uint32_t kMargin = 60;
inline constexpr std::uint32_t kTop = 120, kBottom = 740;  // of the area for the views
inline constexpr std::uint32_t kGap = 90;                  // between two views
inline constexpr std::uint32_t kAreaColumns = kPreviewColumns - 2 * kMargin - 2 * kGap, kAreaRows = kBottom - kTop;
inline constexpr double kMostPixelsPerMm = 120.0;
inline constexpr std::size_t kSamples =
    std::size_t{kAreaColumns} * kSamplesPerPixel * kAreaRows * kSamplesPerPixel;  // of all three maps together

/// Every so many pixels the highest surface is kept, a power of two.
std::uint32_t height_step(const PrintGrid& grid);
std::size_t height_cells(const PrintGrid& grid);

/// Half-open ranges of pixels and layers that hold the object.
struct Extent {
  std::uint32_t column = 0, column_end = 0, row = 0, row_end = 0, layer = 0, layer_end = 0;

  bool empty() const { return column >= column_end; }
  /// Adds columns [begin, end) of a row.
  void hold(std::uint32_t in_row, std::uint32_t begin, std::uint32_t end) {
    column = std::min(column, begin);
    column_end = std::max(column_end, end);
    row = std::min(row, in_row);
    row_end = std::max(row_end, in_row + 1);
  }
};

/// @param words  an image of the grid, as scratch
Extent find_extent(const RRep& rrep, std::span<std::uint64_t> words);
Extent with_supports(Extent extent, const Supports& supports, const PrintGrid& grid);

/// One scale for three views, and where they go.
struct Layout {
  double width_mm = 0, depth_mm = 0, height_mm = 0;  // x, y, z
  double pixels_per_mm = 0;
  std::uint32_t width = 0, depth = 0, height = 0;  // pixels
  std::uint32_t tall = 0;                          // pixels of the tallest view
  std::int64_t front_left = 0, side_left = 0, top_left = 0;
  std::int64_t floor = 0;  // row of the underside in the front and the side view

  double samples_per_mm() const { return pixels_per_mm * kSamplesPerPixel; }
};

Layout lay_out(const Extent& extent, const PrintGrid& grid);

/// What the survey needs besides its maps, from the caller.
struct SurveyScratch {
  std::span<std::uint64_t> section;   ///< an image of the grid
  std::span<std::uint32_t> nearest;   ///< as many as the longer side of the grid has pixels
  std::span<std::uint64_t> found;     ///< words of a row
  std::span<std::uint16_t> heights;   ///< height_cells()
  std::span<std::uint8_t> materials;  ///< the larger of height_cells() and the longer side
};

/// Fills the three depth maps in one sweep over the layers.
void survey(const RRep& rrep, const Supports& supports, const Extent& extent, const Layout& layout,
            const SurveyScratch& scratch, const DepthMap& front, const DepthMap& side, const DepthMap& top);

}  // namespace plumbline::preview
