#pragma once
/// Turns over the scan's own normals where they face into the object.

#include <cstddef>
#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

/// Most bytes of arena that turn_flipped_normals() takes, not counting the rounding of blocks.
std::size_t flipped_normals_bytes(std::uint32_t points);

/// Turns over the normals that contradict the rest of the scan.
///
/// Neighbours that face the same way (join_weight() of at least 1/2) are joined to sheets. Only neighbours in the order of
/// the tree are joined, and every eighth point with its nearest ones, which links the groups of eight. The largest sheet is
/// taken to be right. The others, from large to small, and then the points in no sheet, are turned over if the field of the
/// sheets before them says so (orient_normals(), 2): a sheet that faces the wrong way opens a hole in the surface instead of
/// closing it. A separate part, or the wall of a cavity, does not contradict the field and stays.
///
/// A scan that is inside out as a whole stays so: its normals do not contradict each other.
///
/// @param cloud  in the order of `tree`; overwrites radius[]
/// @returns normals turned over. The same for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<std::uint32_t> turn_flipped_normals(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                           const StageProgress& progress = {});

}  // namespace plumbline
