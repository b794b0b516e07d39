#pragma once
/// The depth maps of the coverage picture: for each sample the depth and what the surface there rests on.

#include <cstdint>
#include <span>

#include "firmware/pictures/preview/preview_shading.hpp"
#include "firmware/pictures/preview/preview_survey.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::preview {

/// The scale that four views share, and where they go on the page.
struct CoverageLayout {
  double samples_per_mm = 0;
  std::uint32_t width = 0, depth = 0, height = 0;  ///< pixels
  std::int64_t left = 0, step = 0;                 ///< of the first view, and to the next one's left

  static CoverageLayout of(const Extent& extent, const PrintGrid& grid, const Page& page);
};

enum class CoverageView : std::uint8_t { kFront, kBack, kAbove, kBelow };

/// Fills the depth map of one view in a sweep over the layers.
/// @param section  scratch: an image of the grid
/// @param arena    for the heights of the surface, taken from the top and released
/// @param depths   DepthMap::material is an Evidence
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Status survey_coverage(const RRep& rrep, const ConfidenceMap& map, const Extent& extent,
                                     const CoverageLayout& layout, std::span<std::uint64_t> section, Arena& arena,
                                     CoverageView view, const DepthMap& depths);

}  // namespace plumbline::preview
