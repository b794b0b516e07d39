#pragma once
/// Shoots all rays of the grid, on several threads, into the crossing store.

#include <array>
#include <cstdint>
#include <numeric>

#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/rays/ray_classifier.hpp"
#include "slicer/rrep/crossing_store.hpp"

namespace plumbline::inline slicer {

inline constexpr std::uint32_t kMaxThreads = 64;

struct RayCounts {
  std::array<std::uint64_t, kRayDecisionCount> decided = {};  ///< rays, by RayDecision
  std::uint64_t guided = 0;         ///< rays whose crossings were looked for near predicted depths only (RayLattice)
  std::uint64_t interpolated = 0;   ///< rays that lie on the sheets of their neighbours
  std::uint64_t thinned_tiles = 0;  ///< tiles that used only some of their points, for lack of room

  /// Rays with crossings, or with points near.
  std::uint64_t interested() const { return std::reduce(decided.begin(), decided.end()); }
};

/// Bytes of arena that a thread takes while it shoots rays.
std::size_t ray_worker_bytes(std::uint32_t tile_capacity);

/// Shoots every ray within the bounds of the cloud's supports. The result does not depend on the number of threads.
/// @param tolerance   mm, see RayLattice
/// @param confidence  may be null
/// @param threads     1 to kMaxThreads
/// @param arena       the workers' memory stays at its top, and the crossings at its bottom
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<CrossingStore> shoot_all_rays(const RayField& field, float tolerance, ConfidenceMap* confidence,
                                                     std::uint32_t threads, Arena& arena, const StageProgress& progress,
                                                     RayCounts& counts);

/// The crossings of another ray of each pixel. It is shot only where it may see something else than the rays around it: between four alike that lie on
/// smooth sheets its crossings are interpolated.
/// @param field  with that ray, with_ray() 1 to kRaysAround
/// @param base   of ray 0, at the bottom of the arena
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<CrossingStore> shoot_other_rays(const RayField& field, const CrossingStore& base,
                                                       std::uint32_t threads, Arena& arena,
                                                       const StageProgress& progress);

}  // namespace plumbline::inline slicer
