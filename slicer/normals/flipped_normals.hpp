#pragma once
/// Patches of a scan whose normals point into the object.

#include <cstddef>
#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

/// Bytes of arena that turn_patches() takes at most, rounding of blocks apart.
std::size_t turned_patches_bytes(std::uint32_t points);

/// Finds the normals that contradict the rest of the scan, and turns them over.
///
/// Neighbours that face the same way are joined (join_weight() of 1/2 and more): the points that stand next to each other in
/// the order of the tree, and the nearest ones of one point in eight, which joins the eights. What is joined is a sheet. The
/// largest one is right as it is; the others, from the larger to the smaller, and at the end the points in no sheet, are
/// turned over where the field of those before says so (orient_normals(), 2): a patch that faces the wrong way opens a hole
/// in the surface instead of closing it. A piece apart, or the inside of a hollow, does not contradict that field and stays.
///
/// A scan that is inside out as a whole stays so: its normals do not contradict each other.
///
/// @param cloud  in the order of `tree`; radius[] is scratch
/// @returns normals that were turned over. The same for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<std::uint32_t> turn_patches(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                   const StageProgress& progress = {});

}  // namespace plumbline
