#pragma once
/// Which side of the surface a normal points to.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

/// Bytes of arena that orient_normals() takes at most, rounding of blocks apart.
std::size_t orientation_bytes(std::uint32_t points);

/// Turns normals of estimated tangent planes so that they all point out of the object.
///
/// 1. Sheets. Neighbours are joined from the surest pair to the least sure one, a spanning forest as of Hoppe et al. 1992,
///    section 3.3 (Kruskal's algorithm over classes of weights): join_weight(), its sign that of the join.
/// 2. Sides of sheets, the largest first. Known normals decide by majority. Otherwise a sheet faces outwards,
///
///      sum_i a_i <n_i, p_i - c> > 0                                              (c: its centroid, a_i: area of a point)
///
///    which is three times the volume if it is closed, and lets the convex side of a partial scan be the outer one; inwards
///    if it lies in another one, as the wall of a hollow does; and it closes the holes in those already oriented:
///
///      - sum_i a_i <n_i, grad W(p_i)> > 0                                 (W: winding number of the oriented ones)
///
///    as Metzer et al., Orienting Point Clouds with Dipole Propagation, 2021, orient patches. Points in no sheet follow the
///    last rule one by one.
///
/// What has no outside by these rules gets a side all the same: a plane, the inside of a bowl without its outside (it is
/// taken for the outside of a dome). A scan's own normals are better; see estimate_normals().
///
/// @param cloud      in the order of `tree`; radius[i]^2 pi is the area of point i
/// @param estimated  bit i % 64 of word i / 64: normal i may be turned. The others are right as they are
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Status orient_normals(Cloud& cloud, const KdTree3& tree, std::span<const std::uint64_t> estimated,
                                    Arena& arena, const StageProgress& progress = {});

}  // namespace plumbline
