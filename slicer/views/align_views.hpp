#pragma once
/// Finds the views that a scan was put together from, and makes them agree.

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

/// Bytes of arena that align_views() takes at most, rounding of blocks apart.
std::size_t align_views_bytes(std::uint32_t points);

/// What was found and done. Nothing was moved where `moved` is 0.
struct ViewAlignment {
  std::uint32_t views = 0;   ///< told apart
  std::uint32_t points = 0;  ///< that are of one of them
  float before = 0;          ///< distance of points from the smooth surface round them, root of the mean square; mm
  float after = 0;           ///< the same with the views moved, mm
  float moved = 0;           ///< how far points of views were moved, root of the mean square; mm
  float ripple = 0;          ///< how far they were off by their view's ripple, which is gone too, the same
};

/// Where noise is a fair share of the points' spacing: find_views(), register_views().
///
/// @param cloud  in the order of `tree`; positions change where views are moved, and then the tree must be built anew.
///               Normals stay as they are: views turn by hundredths of a degree
/// @returns lengths in the unit of the cloud. The same for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<ViewAlignment> align_views(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                  const StageProgress& progress = {});

}  // namespace plumbline
