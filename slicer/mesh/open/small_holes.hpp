#pragma once
/// Closes the small holes of a mesh, and takes back single triangles that are there twice or turned over.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/mesh/mesh_lattice.hpp"
#include "slicer/mesh/open/open_edges.hpp"
#include "slicer/mesh/open/rim_winding.hpp"

namespace plumbline::inline slicer {

struct SmallHoles {
  std::span<const LatticeTriangle> caps;  ///< at the bottom of the arena
  std::uint64_t holes = 0;                ///< that they close
  std::span<const RimCorner> rim;         ///< MeshRim of the edges that are left open, at the bottom of the arena
};

/// A hole with up to this many corners is small.
inline constexpr std::size_t kMostCorners = 8;

/// Bytes of the arena for that many runs of open edges.
std::size_t small_hole_bytes(std::uint64_t runs);

/// Finds the loops of open edges with at most kMostCorners corners, and closes each by triangles between its corners.
///
/// The winding number of the mesh is that of the mesh with all its loops closed, less that of the caps; and a flat cap's passes one
/// half at the cap. So closing a small hole flat is what the winding number says of it, but for the influence of other holes. A
/// triangle that is there twice leaves a loop that runs the other way, whose cap cancels it; one that is turned over a loop that runs
/// twice, with two caps. If each such loop has three corners, all pixels are those of the undamaged mesh.
///
/// A triangle or a pair of them that nothing else touches has a small loop, too. Its cap would cancel it, though it may be part of a
/// surface whose corners don't meet. It is known by its edges, which have fewer users than there are corners, and stays open.
/// @param steps  mm in a step of the lattice
/// @param most   corners of a loop that is closed: kMostCorners, or 0
/// @param arena  small_hole_bytes(edges.runs()) from the bottom; the caller releases them
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<SmallHoles> close_small_holes(const OpenEdges& edges, const Vec3d& steps, std::size_t most,
                                                     Arena& arena);

}  // namespace plumbline::inline slicer
