#pragma once
/// Normals for scans that bring none: tangent planes by principal components, sides by propagation (DESIGN 3, stage 1b).

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

/// Bytes of arena that complete_normals() takes at most for a cloud of `points`, rounding of blocks apart.
std::size_t normals_bytes(std::uint32_t points);

/// Fills in the normals that are not known, facing outwards.
///
/// The direction is the least principal axis of the nearest points (Hoppe et al., Surface Reconstruction from Unorganized
/// Points, 1992, section 3.2): 20 of them, more where their residual from the plane is large for their reach, so that the
/// plane of a noisy scan does not follow its noise.
///
/// The side is found as orient_normals() says. Points with a known normal keep it and decide for the others around them.
///
/// A point whose neighbours lie on a line or in one place has no plane: its normal stays unknown, and clustering makes it
/// noise.
///
/// @param cloud  in the order of `tree`; radius[] is scratch and holds sqrt(area / pi) of each point's share of the surface
///               when this returns; clustering sets it anew
/// @returns normals filled in. The same bits on any machine, for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<std::uint32_t> estimate_normals(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                       const StageProgress& progress = {});

struct NormalCounts {
  std::uint32_t estimated = 0;  ///< points whose normal the scan did not have
  std::uint32_t turned = 0;     ///< points whose normal contradicted the others
};

/// Fills in what normals the scan lacks, and turns over what contradicts the rest (turn_patches()) where it has some of its
/// own.
///
/// @param cloud  as for estimate_normals()
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<NormalCounts> complete_normals(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                      const StageProgress& progress = {});

}  // namespace plumbline
