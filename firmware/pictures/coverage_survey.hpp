#pragma once
/// The depth maps of the coverage picture: for each sample the depth and what the surface there rests on.

#include <array>
#include <cstdint>

#include "firmware/pictures/preview/preview_shading.hpp"
#include "firmware/pictures/preview/preview_survey.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::firmware::inline pictures::preview {

/// The scale that four views share, and where they go on the page.
struct CoverageLayout {
  double samples_per_mm = 0;
  std::uint32_t width = 0, depth = 0, height = 0;  ///< pixels
  std::int64_t left = 0, step = 0;                 ///< of the first view, and to the next one's left

  static CoverageLayout of(const Extent& extent, const PrintGrid& grid, const Page& page);
};

/// Fills the depth maps of two views, each in a sweep over the layers, at once.
/// @param arena  for two images of the grid and the heights of the surface, taken from the top and released
/// @param walls  whether the views are those from the front and the back, or from above and below
/// @param views  DepthMap::material is an Evidence
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Status survey_coverage(const RRep& rrep, const ConfidenceMap& map, const Extent& extent,
                                     const CoverageLayout& layout, Arena& arena, bool walls,
                                     const std::array<DepthMap, 2>& views);

}  // namespace plumbline::firmware::inline pictures::preview
