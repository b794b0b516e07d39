#pragma once
/// What all loops that shoot rays share.

#include <omp.h>

#include <cstdint>
#include <span>

#include "slicer/core/error.hpp"
#include "slicer/core/loop_progress.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/rays/ray_classifier.hpp"
#include "slicer/rrep/crossing_store.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// Appends a crossing to those of its ray. Neighbours with no sampling height between them cancel in pairs.
/// @param ray    heights; room for one more
/// @param count  of them, in and out
inline void add_height(CrossingHeight height, CrossingHeight* ray, std::uint32_t& count) {
  if (count > 0 && ray[count - 1].layer() == height.layer()) {
    --count;
  } else {
    ray[count++] = height;
  }
}
/// After the last: a crossing above the last sampling height has no effect.
inline void end_heights(const PrintGrid& grid, const CrossingHeight* ray, std::uint32_t& count) {
  if (count > 0 && ray[count - 1].layer() >= grid.layers) --count;
}

inline constexpr std::size_t kMostHeights = std::size_t{kRaysPerTile} * RayClassifier::kMaxCrossings;  ///< of a tile

/// Calls shoot(tile, thread) for all tiles of a store; one thread shoots all that share a column's winding numbers.
/// @param shoot  returns a Status; the first that is an error ends the loop
/// @retval ErrorCode::kCancelled
template <class Shoot>
[[nodiscard]] Status for_each_tile(const CrossingStore& store, std::uint32_t threads, const StageProgress& progress,
                                   Shoot shoot) {
  constexpr std::uint32_t kSide = RayClassifier::kColumnTiles;
  const std::uint32_t across = (store.tile_columns() + kSide - 1) / kSide;
  const std::uint32_t columns = across * ((store.tile_rows() + kSide - 1) / kSide);
  LoopProgress loop(progress, columns * kSide * kSide);
  Status status;
#pragma omp parallel for schedule(dynamic, 2) num_threads(static_cast <int>(threads))
  for (std::uint32_t column = 0; column < columns; ++column) {
    for (std::uint32_t t = 0; t < kSide * kSide && loop.step(column * kSide * kSide + t); ++t) {
      const std::uint32_t x = column % across * kSide + t % kSide;
      const std::uint32_t y = column / across * kSide + t / kSide;
      if (x >= store.tile_columns() || y >= store.tile_rows()) continue;
      const Status shot = shoot(y * store.tile_columns() + x, static_cast<std::size_t>(omp_get_thread_num()));
      if (shot) continue;
#pragma omp critical
      status = shot;
      loop.stop();
    }
  }
  PLUMBLINE_TRY(status);
  if (loop.stopped()) return fail(ErrorCode::kCancelled, "cancelled while shooting rays");
  return {};
}

}  // namespace plumbline::inline slicer
