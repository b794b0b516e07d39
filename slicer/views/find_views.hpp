#pragma once
/// Tells the views of a merged scan apart by the grids that their points lie on.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/views/grid_growth.hpp"
#include "slicer/views/view_grid.hpp"

namespace plumbline {

inline constexpr std::uint32_t kMostViews = 64;

struct FoundViews {
  std::uint32_t count = 0;                 ///< of views
  std::uint32_t points = 0;                ///< that are of one of them
  std::array<ViewGrid, kMostViews> grids;  ///< of each view; the first `count` of them
};

/// Bytes of arena that find_views() takes at most, rounding of blocks apart.
std::size_t find_views_bytes();

/// A camera's noise moves a point along the ray of its pixel, so the points of a view lie on the view's rays however noisy
/// they are and however the views were shuffled. In a patch of the scan the spectrum shows the grids of all views that see it
/// (PatchSpectrum); each is followed over the scan (GridGrowth), takes its points, and leaves the others to be looked for
/// again, until patch after patch shows none. A scanner whose points lie on no grid, since its software has resampled,
/// smoothed or thinned them, has no views here.
///
/// @param cloud    in the order of `tree`, with normals, to tell which way a patch faces. Points that are the mean of several
///                 are not looked for views in, but may be of one
/// @param spacing  side of a square as large as a point's share of the surface, mm
/// @param view_of  set to each point's view, kNoView where none is known
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<FoundViews> find_views(const Cloud& cloud, const KdTree3& tree, float spacing,
                                              std::span<std::uint8_t> view_of, Arena& arena,
                                              const StageProgress& progress = {});

}  // namespace plumbline
