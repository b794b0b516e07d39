#pragma once
/// Finds the views that a noisy scan was merged from, and aligns them.

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/views/registration.hpp"

namespace plumbline {

/// Upper bound of the arena bytes that align_views() takes, without alignment.
std::size_t align_views_bytes(std::uint32_t points, std::uint32_t threads);

struct ViewCounts;
/// What it has taken of them.
std::size_t align_views_bytes(const ViewCounts& found, std::uint32_t points, std::uint32_t threads);

/// Result of align_views(). Nothing was moved if `moved` is 0.
struct ViewCounts {
  bool searched = false;     ///< the scan is noisy enough to look for views
  std::uint32_t views = 0;   ///< views found
  std::uint32_t points = 0;  ///< points that belong to a view
};
struct ViewAlignment : ViewCounts, Registration {};

/// Calls find_views() and register_views() where noise exceeds a fifth of the points' spacing.
///
/// @param cloud  in the order of `tree`. Where views are moved positions change, and the tree must be built again.
///               Normals don't change, since views turn by hundredths of a degree
/// @returns lengths in the unit of the cloud; the same for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<ViewAlignment> align_views(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                  const StageProgress& progress = {});

}  // namespace plumbline
