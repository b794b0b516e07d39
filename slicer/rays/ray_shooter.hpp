#pragma once
/// Shoots all rays of the grid, on several threads, into the crossing store.

#include <array>
#include <cstdint>
#include <numeric>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/rays/ray_lattice.hpp"
#include "slicer/rrep/crossing_store.hpp"

namespace plumbline {

struct RayCounts {
  std::array<std::uint64_t, kRayDecisionCount> decided = {};  ///< rays, by RayDecision
  std::uint64_t guided = 0;         ///< rays whose crossings were looked for near predicted depths only (RayLattice)
  std::uint64_t interpolated = 0;   ///< rays that lie on the sheets of their neighbours
  std::uint64_t thinned_tiles = 0;  ///< tiles that used only some of their points, for lack of room

  /// Rays with crossings, or with points near.
  std::uint64_t interested() const { return std::reduce(decided.begin(), decided.end()); }
};

/// Shoots the rays of the grid with one worker a thread.
class RayShooter {
 public:
  static constexpr std::uint32_t kMaxThreads = 64;

  /// Bytes of arena for one worker.
  static std::size_t bytes_needed(std::uint32_t tile_capacity);

  /// Takes the workers' memory from the top of the arena. Call it before CrossingStore::create(), which takes all that is left.
  /// @param tolerance   mm, see RayLattice
  /// @param confidence  may be null
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<RayShooter> create(const RayField& field, float tolerance, ConfidenceMap* confidence,
                                                   std::uint32_t threads, Arena& arena);

  /// Shoots every ray within the bounds of the cloud's supports and stores its crossings. The result does not depend on the number of
  /// threads.
  /// @retval ErrorCode::kOutOfMemory, kCancelled
  [[nodiscard]] Expected<RayCounts> shoot(CrossingStore& store, ProgressSink* progress);

 private:
  struct Worker {
    RayClassifier classifier;
    RayLattice* lattice = nullptr;
    std::span<std::uint16_t> layers;
    RayCounts counts;
  };
  Status shoot_tile(Worker& worker, std::uint32_t tile, CrossingStore& store) const;

  PrintGrid grid_;
  ConfidenceMap* confidence_ = nullptr;
  Box3f bounds_;  ///< of the cloud's supports, mm
  std::array<Worker, kMaxThreads> workers_;
  std::uint32_t threads_ = 1;
};

}  // namespace plumbline
