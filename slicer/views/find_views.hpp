#pragma once
/// Finds the views of a merged scan by the pixel grids that their points lie on.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/views/grid_growth.hpp"
#include "slicer/views/view_grid.hpp"

namespace plumbline {

/// Views of a scan. A merged scan has a dozen or some more; view numbers are bytes, and the normal equations of the
/// registration grow with the square of this.
inline constexpr std::uint32_t kMaxViews = 64;

struct FoundViews {
  std::uint32_t count = 0;                ///< number of views
  std::uint32_t points = 0;               ///< points that belong to a view
  std::array<ViewGrid, kMaxViews> grids;  ///< grid of each view; the first `count` are set
};

/// Upper bound of the arena bytes that find_views() takes, without alignment.
std::size_t find_views_bytes(std::uint32_t threads);

/// Assigns each point to its view.
///
/// A camera's noise moves a point along the ray of its pixel, so the points of a view lie on the view's rays, however
/// noisy they are and in whatever order the file has them. The spectrum of a patch shows the grids of all views that
/// see it (PatchGrids). Each grid is followed over the scan (GridGrowth) and takes its points; the search continues
/// among the rest until many patches in a row show no grid. Scans that software has resampled, smoothed or thinned
/// have no grid, so no views are found.
///
/// @param cloud    in the order of `tree`, with normals, which say what side a patch faces. The search uses only points
///                 that are not averages of several; averages are assigned at the end
/// @param spacing  side of a square of one point's share of the surface, mm
/// @param view_of  set to each point's view, kNoView where none is known
/// @returns the same for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<FoundViews> find_views(const Cloud& cloud, const KdTree3& tree, float spacing,
                                              std::span<std::uint8_t> view_of, Arena& arena,
                                              const StageProgress& progress = {});

}  // namespace plumbline
