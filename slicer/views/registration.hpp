#pragma once
/// Moves the views of a scan so that they agree.

#include <cstddef>
#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
namespace plumbline::inline slicer {

/// Arena bytes that register_views() takes for so many views, without alignment.
std::size_t register_views_bytes(std::uint32_t views);

/// Result of register_views(), in the unit of the cloud.
struct Registration {
  std::uint32_t views = 0;  ///< that were measured; 0: there are less than two, or runs in a scan without noise
  float before = 0;         ///< RMS distance of the points from the smooth surface around them
  float after = 0;          ///< the same after the views were moved; equal to `before` if they were left in place
  float moved = 0;          ///< RMS motion of the points; 0 if the views were left in place
};

/// Moves all views at once, each as a rigid body, so that the points around a place lie on one surface, whatever view
/// they belong to: Gauss-Newton on the distances of the points from a paraboloid through their neighbourhood (Chen and
/// Medioni, Object modelling by registration of multiple range images, 1992; here the paraboloid is eliminated instead
/// of one view held fixed).
///
/// What the scan does not determine, such as the distance between a plate's upper and lower side, stays as it is: a normal prior keeps
/// motions small, with a variance learnt from the motions that the scan does determine. Of all rigid motions of the scan as a whole, which
/// its points don't determine, the one is taken that leaves them nearest to where they were. Views whose fit hardly improves are left in
/// place.
///
/// @param cloud  in the order of `tree`. Where views are moved positions change, and the tree must be built again. Normals and the
///               scanners' places don't change, since views turn by hundredths of a degree
/// @returns the same for any number of threads; nothing moves where there are less than two views
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<Registration> register_views(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                    const StageProgress& progress = {});

}  // namespace plumbline::inline slicer
