#pragma once
/// Makes estimated normals face outwards.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline::inline slicer {

/// Most bytes of arena that orient_normals() takes, not counting the rounding of blocks.
std::size_t orientation_bytes(std::uint32_t points);

/// Turns estimated normals over so that all face out of the object.
///
/// 1. Sheets. Neighbours are joined, the surest pairs first, to a spanning forest as by Hoppe et al. 1992, section 3.3:
///    Kruskal's algorithm over classes of join_weight(). Its sign says whether the two face the same side.
/// 2. Sides of sheets, the largest first. Known normals decide by majority. Otherwise a sheet faces outwards if
///
///      sum_i a_i <n_i, p_i - c> > 0                                              (c: its centroid, a_i: area of a point)
///
///    The sum is three times the volume of a closed sheet; of a partial one it makes the convex side the outer one. A sheet
///    inside others, as the wall of a cavity, faces inwards. A sheet also closes the holes in those already oriented:
///
///      - sum_i a_i <n_i, grad W(p_i)> > 0                                 (W: winding number of the oriented ones)
///
///    as Metzer et al., Orienting Point Clouds with Dipole Propagation, 2021. Points in no sheet follow the last rule, one
///    by one.
///
/// Sheets without an outside by these rules get a side too: a plane gets either, and the inside of a bowl without its
/// outside is taken for the outside of a dome. A scan's own normals are better; see estimate_normals().
///
/// @param cloud      in the order of `tree`; radius[i]^2 pi is the area of point i
/// @param estimated  bit i % 64 of word i / 64: normal i may be turned over. The others are right, as are those of points of which it is known
///                   from where they were seen. Empty: none is
/// @returns normals turned over
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<std::uint32_t> orient_normals(Cloud& cloud, const KdTree3& tree,
                                                     std::span<const std::uint64_t> estimated, Arena& arena,
                                                     const StageProgress& progress = {});

}  // namespace plumbline::inline slicer
