#pragma once
/// Completes the normals of a scan: tangent planes by principal components, sides by the scanner's place or by propagation.

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/normals/normal_counts.hpp"

namespace plumbline::inline slicer {

/// Whether a scan's own normals say which side is outside. Those of Gaussian splats don't.
enum class NormalSides : std::uint8_t { kKnown, kUnknown };

/// Most bytes of arena that complete_normals() takes for a cloud of `points`, not counting the rounding of blocks.
std::size_t normals_bytes(std::uint32_t points);

/// Estimates the normals that are not known, facing outwards.
///
/// The direction is the least principal axis of the nearest points (Hoppe et al., Surface Reconstruction from Unorganized
/// Points, 1992, section 3.2): 20 points, more if their residual from the plane is large for their distance, so that the
/// plane does not follow the noise.
///
/// Where it is known from where a point was seen, its normal faces that place: face_scanners(). For the others
/// orient_normals() finds the side. Known normals stay as they are, unless they contradict the scanner, and decide for the points around them.
///
/// A point whose neighbours lie on a line or in one place has no plane. Its normal stays unknown, and clustering makes it
/// noise.
///
/// @param cloud  in the order of `tree`; afterwards radius[] is sqrt(area / pi) of each point's share of the surface
/// @param sides  kUnknown: the known normals keep their direction only, and only within 30 degrees of that of their neighbours' plane; the
///               others are estimated. The side of all is found
/// @returns normals estimated, and those that contradicted the scanner. The same bits on any machine, for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<NormalCounts> estimate_normals(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                      const StageProgress& progress = {},
                                                      NormalSides sides = NormalSides::kKnown);

/// Estimates missing normals, and all of them where their directions are not the surface's, as with NormalSides::kUnknown. If the scan has
/// some of its own, also turns over those that face into the object: see face_scanners() and turn_flipped_normals(). Forgets the places of
/// false scanners before: forget_false_scanners().
///
/// @param cloud  as for estimate_normals()
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<NormalCounts> complete_normals(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                      const StageProgress& progress = {},
                                                      NormalSides sides = NormalSides::kKnown);

}  // namespace plumbline::inline slicer
