#pragma once
/// What a picture shows of the print, and where each view goes on the page.

#include <algorithm>
#include <cstdint>
#include <span>

#include "firmware/pictures/preview/preview.hpp"
#include "firmware/pictures/preview/preview_shading.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures::preview {

/// A picture and the area for the views on it, pixels.
struct Page {
  std::uint32_t columns = 0, rows = 0;
  std::uint32_t margin = 0;           ///< free on the left and the right
  std::uint32_t top = 0, bottom = 0;  ///< rows of the area
  std::uint32_t gap = 0;              ///< least columns between two views
  std::uint32_t beside = 0;           ///< more columns that are free on the right

  std::uint32_t area_columns(std::uint32_t views) const { return columns - beside - 2 * margin - (views - 1) * gap; }
  std::uint32_t area_rows() const { return bottom - top; }
};

/// A part of a picture, pixels.
struct PagePart {
  std::uint32_t left = 0, top = 0, columns = 0, rows = 0;
};

inline constexpr std::uint32_t kMargin = 60;
inline constexpr Page kPreviewPage{kPreviewColumns, kPreviewRows, kMargin, 120, 740, 90};
inline constexpr Page kCoveragePage{kPreviewColumns, kPreviewRows, kMargin, 120, 740, 60};
inline constexpr double kMostPixelsPerMm = 120.0;

/// Free around the views of a picture that has nothing else.
inline constexpr std::uint32_t kRim = 3;

constexpr Page page_of_views(std::uint32_t columns, std::uint32_t rows, std::uint32_t gap) {
  return {columns, rows, kRim, kRim, rows - kRim, gap};
}

/// Half-open ranges of pixels and layers that hold the object.
struct Extent {
  std::uint32_t column = 0, column_end = 0, row = 0, row_end = 0, layer = 0, layer_end = 0;

  bool empty() const { return column >= column_end; }
  /// Grows the extent to hold columns [begin, end) of a row.
  void hold(std::uint32_t in_row, std::uint32_t begin, std::uint32_t end) {
    column = std::min(column, begin);
    column_end = std::max(column_end, end);
    row = std::min(row, in_row);
    row_end = std::max(row_end, in_row + 1);
  }
};

/// The extent of the object.
/// @param words  scratch: an image of the grid
Extent find_extent(const RRep& rrep, std::span<std::uint64_t> words);
/// `extent` grown to hold the supports.
Extent with_supports(Extent extent, const Supports& supports, const PrintGrid& grid);

enum class Views : std::uint8_t { kFront = 1, kThreeSides = 3 };

/// The scale that the views share, and where they go. A view that is not shown has a place, too.
struct Layout {
  double width_mm = 0, depth_mm = 0, height_mm = 0;  // x, y, z
  double pixels_per_mm = 0;
  std::uint32_t width = 0, depth = 0, height = 0;  // pixels
  std::uint32_t tall = 0;                          // pixels of the tallest view
  std::int64_t front_left = 0, side_left = 0, top_left = 0;
  std::int64_t floor = 0;  // row of the underside in the front and the side view

  double samples_per_mm() const { return pixels_per_mm * kSamplesPerPixel; }
};

/// Chooses the largest scale at which the views fit the page.
Layout lay_out(const Extent& extent, const PrintGrid& grid, const Page& page, Views views);

}  // namespace plumbline::firmware::inline pictures::preview
