#pragma once
/// From the hits of all rays to crossings: which stretches of a ray are solid.

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/mesh/hit_list.hpp"
#include "slicer/mesh/mesh_counts.hpp"
#include "slicer/rrep/crossing_store.hpp"

namespace plumbline {

/// The winding number of a mesh that is not closed.
struct MeshField {
  const WindingTree* winding = nullptr;
  float cell = 0;     ///< mm: nearer to the surface the number is not trusted
  BitImage doubtful;  ///< one pixel a tile: where the hits miss solid parts. Set by find_doubtful()
  std::uint32_t first_column = 0, end_column = 0;  ///< tiles that the object's box covers
  std::uint32_t first_row = 0, end_row = 0;
};

/// Compares hits and winding number along one ray of each tile, and marks the tiles where the hits miss solid parts, and their
/// neighbours: holes are above each other there, and a ray through both looks whole.
/// @returns false if the caller cancelled
[[nodiscard]] bool find_doubtful(MeshField& field, const HitList& hits, const PrintGrid& grid,
                                 const StageProgress& progress);

/// Stores the crossings of all rays.
///
/// A place on a ray is solid if the hits below it don't cancel: their sum is the winding number of the surface (non-zero rule). So
/// shells inside of each other, shells that overlap and a mesh that is inside out are solid throughout. Where a ray does not enter as
/// often as it exits, the sum from above says otherwise in some stretches. There the winding number of all triangles decides, as it
/// does for scans; and in doubtful tiles in all empty stretches longer than two cells.
/// @param field   null: the mesh is closed
/// @param arena   kMostRayCrossings of every ray of a tile for each thread, from the top; the rest for the store
/// @param counts  rays, broken_rays, decided_rays and crowded_rays are set
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<CrossingStore> resolve_hits(const HitList& hits, const PrintGrid& grid, const MeshField* field,
                                                   std::uint32_t threads, Arena& arena, const StageProgress& progress,
                                                   MeshCounts& counts);

}  // namespace plumbline
