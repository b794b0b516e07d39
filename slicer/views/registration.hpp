#pragma once
/// Moves the views of a scan so that they agree.

#include <cstddef>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/views/moved_views.hpp"

namespace plumbline {

/// Arena bytes that register_views() takes for so many views, without alignment.
std::size_t register_views_bytes(std::uint32_t views, std::uint32_t threads);

/// Result of register_views(), in the unit of the cloud.
struct Registration {
  float before = 0;  ///< RMS distance of the points from the smooth surface around them
  float after = 0;   ///< the same after the views were moved; equal to `before` if they were left in place
  float moved = 0;   ///< RMS motion of a view's points
  float ripple = 0;  ///< RMS ripple that was removed; part of `moved`
};

/// Moves all views at once, each as a rigid body, so that the points around a place lie on one surface, whatever view
/// they belong to: Gauss-Newton on the distances of the points from a paraboloid through their neighbourhood (Chen and
/// Medioni, Object modelling by registration of multiple range images, 1992; here the paraboloid is eliminated instead
/// of one view held fixed). After the first rounds, ripple is estimated from each view's residuals (WaveSearch) and
/// removed, in turn with the motions.
///
/// What the scan does not determine, such as the distance between a plate's upper and lower side, stays as it is: a
/// normal prior keeps motions small, with a variance learnt from the motions that the scan does determine. The sum of
/// all motions is 0, so that the scan as a whole stays in place. Views whose fit hardly improves, or that moved much farther
/// than the points were off the surface, are left in place.
///
/// @returns the same for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<Registration> register_views(Cloud& cloud, const KdTree3& tree, const Views& views, Arena& arena,
                                                    const StageProgress& progress = {});

}  // namespace plumbline
