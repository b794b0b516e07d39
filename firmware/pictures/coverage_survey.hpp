#pragma once
/// The depth maps of the coverage picture, each sample with the evidence of its place.

#include <cstdint>
#include <span>

#include "firmware/pictures/preview_shading.hpp"
#include "firmware/pictures/preview_survey.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::preview {

/// Four views of one scale, and where they go on the page.
struct CoverageLayout {
  double samples_per_mm = 0;
  std::uint32_t width = 0, depth = 0, height = 0;  ///< pixels
  std::int64_t left = 0, step = 0;                 ///< of the first view, and to the next one's left

  static CoverageLayout of(const Extent& extent, const PrintGrid& grid);
};

/// DepthMap::material is an Evidence.
struct CoverageViews {
  DepthMap front, back, top, below;
};

/// Fills those of the four maps that have any samples, in one sweep over the layers.
/// @param section  an image of the grid, as scratch
/// @param arena    for the heights of the surface, from the top, given back
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Status survey_coverage(const RRep& rrep, const ConfidenceMap& map, const Extent& extent,
                                     const CoverageLayout& layout, std::span<std::uint64_t> section, Arena& arena,
                                     const CoverageViews& views);

}  // namespace plumbline::preview
