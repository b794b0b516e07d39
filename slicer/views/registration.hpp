#pragma once
/// Moves the views of a scan so that they agree.

#include <cstddef>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/views/moved_views.hpp"

namespace plumbline {

/// Bytes of arena that register_views() takes at most, rounding of blocks apart.
std::size_t register_views_bytes();

/// What registration did, mm.
struct Registration {
  float before = 0;  ///< points from the smooth surface round them, root of the mean square
  float after = 0;   ///< the same, once the views have moved; as before where they were left where they are
  float moved = 0;   ///< of a point of a view, root of the mean square
  float ripple = 0;  ///< the share of this that was ripple
};

/// Moves each view as a rigid body, all of them at once, so that the points of different views about a place lie on one
/// surface there: Gauss and Newton's method on the distances of points from a paraboloid through their neighbourhood (Chen
/// and Medioni, Object modelling by registration of multiple range images, 1992, with the paraboloid eliminated instead of
/// one view held). What nothing tells, such as how far a plate's upper side is from its lower, stays as it is: motions are
/// held small, as if they were normally distributed with the deviation that those show which the scan does tell. The sum of
/// all motions is nought, so the scan as a whole stays where it is. In turn with that, what each view is still off by is
/// looked through for ripple (WaveSearch), which is taken out.
///
/// @returns the same for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<Registration> register_views(Cloud& cloud, const KdTree3& tree, const Views& views, Arena& arena,
                                                    const StageProgress& progress = {});

}  // namespace plumbline
