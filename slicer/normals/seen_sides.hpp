#pragma once
/// Turns normals to the side that the scanner saw.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline slicer {

/// The normal of point i, on the side that its scanner saw. Where another scanner saw the plane from behind, its points lie on both sides of
/// a thin wall or at an edge; the plane is then fitted to those seen from about the same place as point i.
/// @param normal  estimated from the points `points`
Vec3f seen_normal(const Cloud& cloud, const KdTree3& tree, std::uint32_t i, const Vec3f& normal,
                  std::span<const Neighbour> points);

/// Turns over the normals that face away from the scanner, where a point's view says where it stood:
///
///   <n, p - s> > 0                                                                 (s: the scanner's place)
///
/// Where the scanner looked along the surface, within 30 degrees, a small error of the normal changes its side; there the neighbours vote, too.
///
/// @param estimated  as for orient_normals(): these are not counted
/// @returns normals turned over; the same for any number of threads
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<std::uint32_t> face_scanners(Cloud& cloud, const KdTree3& tree,
                                                    std::span<const std::uint64_t> estimated, Arena& arena);

}  // namespace plumbline::inline slicer
