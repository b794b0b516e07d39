#pragma once
/// Turns over the scan's own normals where they face into the object.

#include <cstddef>
#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/normals/normal_counts.hpp"

namespace plumbline::inline slicer {

/// Most bytes of arena that turn_flipped_normals() takes, not counting the rounding of blocks.
std::size_t flipped_normals_bytes(std::uint32_t points);

/// Turns over the normals that face into the object. Those of points of which it is known from where they were seen are right:
/// face_scanners() comes before.
///
/// Neighbours that face the same way are joined to sheets. The largest sheet is taken to be right. The others, from large to
/// small, and then the points in no sheet, are turned over if the field of the sheets before them says so (orient_normals(), 2):
/// a sheet that faces the wrong way opens a hole in the surface instead of closing it. A separate part, or the wall of a
/// cavity, does not contradict the field and stays. So does a single point that the field hardly tells, on a sheet of its own behind that of a
/// thin wall's other side, which more views saw.
///
/// Then the winding number on the largest sheet tells whether the scan as a whole is inside out: 1/2 on a closed surface, -1/2
/// if all normals face into it. If so the largest sheet is turned over, and the others are asked again. A height field stays,
/// since it can be a valley.
///
/// If many pairs of neighbours face opposite sides, such sheets mean little. Then only the directions are kept, and
/// orient_normals() finds all sides. Thin walls and narrow gaps don't count: there, neighbours all face away from each other,
/// or all face each other; where normals were turned at random, half do.
///
/// @param cloud  in the order of `tree`; overwrites radius[] with the radius of each point's share of the surface
/// @returns counts, with none estimated. The same for any number of threads
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<NormalCounts> turn_flipped_normals(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                                          const StageProgress& progress = {});

}  // namespace plumbline::inline slicer
