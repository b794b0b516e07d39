#pragma once
/// From the hits of all rays to crossings: which stretches of a ray are solid.

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/mesh/hit_list.hpp"
#include "slicer/mesh/mesh_counts.hpp"
#include "slicer/mesh/mesh_ray.hpp"
#include "slicer/rrep/crossing_store.hpp"

namespace plumbline::inline slicer {

/// Compares hits and winding number along one ray of each tile, and marks the tiles where the hits miss solid parts, and their
/// neighbours: holes are above each other there, and a ray through both looks whole.
/// @param arena  gets back what it takes from the top
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Status find_doubtful(MeshField& field, const HitList& hits, const PrintGrid& grid, std::uint32_t threads,
                                   Arena& arena, const StageProgress& progress);

/// As WindingTree::set_base(), for a field with a rim: by the rays in the middle of all tiles.
/// @returns whether the surface is mirrored
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<bool> mirror_open_underside(MeshField& field, const HitList& hits, const PrintGrid& grid,
                                                   float height, Arena& arena);

/// Bytes of the arena for resolve_hits(), without its store.
/// @param field  null: the mesh is closed
std::size_t resolve_bytes(std::uint32_t threads, const MeshField* field);

/// Stores the crossings of all rays.
///
/// A place on a ray is solid if the hits below it don't cancel: their sum is the winding number of the surface (non-zero rule). So
/// shells inside of each other, shells that overlap and a mesh that is inside out are solid throughout. Where a ray does not enter as
/// often as it exits, the sum from above says otherwise in some stretches. There the winding number of all triangles decides, as it
/// does for scans; and in doubtful tiles in all empty stretches longer than two cells.
/// @param field   null: the mesh is closed
/// @param arena   resolve_bytes() from the top; the rest for the store
/// @param counts  rays, broken_rays, decided_rays, asked_rays and crowded_rays are set
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<CrossingStore> resolve_hits(const HitList& hits, const PrintGrid& grid, const MeshField* field,
                                                   std::uint32_t threads, Arena& arena, const StageProgress& progress,
                                                   MeshCounts& counts);

}  // namespace plumbline::inline slicer
