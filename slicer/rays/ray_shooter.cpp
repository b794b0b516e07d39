#include "slicer/rays/ray_shooter.hpp"

#include <algorithm>

#include "slicer/rays/ray_lattice.hpp"
#include "slicer/rays/tile_loop.hpp"

namespace plumbline::inline slicer {
namespace {

/// Takes the heights of the crossings of one ray.
/// @param evidence  out, of each crossing that is left; room for RayClassifier::kMaxCrossings
/// @returns how many are left
std::uint32_t take_heights(std::span<const RayCrossing> crossings, const PrintGrid& grid, CrossingHeight* out,
                           Evidence* evidence) {
  std::uint32_t count = 0;
  for (const RayCrossing& crossing : crossings) {
    evidence[count] = crossing.evidence;
    add_height(height_of(crossing.depth, grid), out, count);
  }
  end_heights(grid, out, count);
  return count;
}

/// What a thread shoots with.
struct Worker {
  RayClassifier classifier;
  RayLattice lattice;
  std::span<CrossingHeight> heights;
  RayCounts counts;
};

Status shoot_tile(const RayField& field, const Box3f& bounds, std::uint32_t tile, Worker& worker,
                  ConfidenceMap* confidence, CrossingStore& store) {
  const PrintGrid& grid = field.grid;
  const std::uint32_t column = tile % store.tile_columns() * kTileSide;
  const std::uint32_t row = tile / store.tile_columns() * kTileSide;
  const std::uint32_t columns = std::min(kTileSide, grid.columns - column);
  const std::uint32_t rows = std::min(kTileSide, grid.rows - row);
  const Vec2f low(static_cast<float>(column) * grid.pitch_x_mm, static_cast<float>(row) * grid.pitch_y_mm);
  const Vec2f high =
      low + Vec2f(static_cast<float>(columns) * grid.pitch_x_mm, static_cast<float>(rows) * grid.pitch_y_mm);
  if ((low.array() > bounds.high.head<2>().array()).any() || (high.array() < bounds.low.head<2>().array()).any()) {
    return {};
  }
  worker.classifier.begin_tile(column, row);
  RayCounts& total = worker.counts;
  total.thinned_tiles += worker.classifier.gatherer().thinned() ? 1 : 0;

  RayLattice& lattice = worker.lattice;
  const bool whole = columns * rows == kRaysPerTile;
  if (whole) {
    lattice.decide(worker.classifier, column, row);
    total.guided += lattice.guided();
    total.interpolated += lattice.interpolated();
  }
  std::array<std::uint8_t, kRaysPerTile> counts{};
  std::array<Evidence, RayClassifier::kMaxCrossings + 1> evidence{};
  std::uint32_t used = 0;
  for (std::uint32_t r = 0; r < rows; ++r) {
    for (std::uint32_t c = 0; c < columns; ++c) {
      const std::uint32_t at = r * kTileSide + c;
      const TileRay& known = lattice.ray(c, r);
      const ClassifiedRay ray = whole && known.known
                                    ? ClassifiedRay{std::span(known.crossing).first(known.count), known.decision}
                                    : worker.classifier.ray(column + c, row + r);
      const std::uint32_t n = take_heights(ray.crossings, grid, &worker.heights[used], evidence.data());
      for (std::uint32_t i = 0; confidence != nullptr && i < n; ++i) {
        confidence->add(column + c, row + r, worker.heights[used + i].layer(), evidence[i]);
      }
      counts[at] = static_cast<std::uint8_t>(n);
      used += n;
      if (ray.decision == RayDecision::kAway) continue;
      ++total.decided[static_cast<std::size_t>(ray.decision)];
    }
  }
  return used > 0 ? store.put(tile, counts, worker.heights.first(used)) : Status{};
}

}  // namespace

std::size_t ray_worker_bytes(std::uint32_t tile_capacity) {
  return sizeof(Worker) + RayClassifier::bytes_needed(tile_capacity) +
         Arena::rounded(kMostHeights * sizeof(CrossingHeight));
}

Expected<CrossingStore> shoot_all_rays(const RayField& field, float tolerance, ConfidenceMap* confidence,
                                       std::uint32_t threads, Arena& arena, const StageProgress& progress,
                                       RayCounts& counts) {
  const auto workers = arena.take_top<Worker>(threads, "rays");
  PLUMBLINE_TRY(workers);
  for (Worker& worker : *workers) {
    const auto classifier = RayClassifier::create(field, arena);
    PLUMBLINE_TRY(classifier);
    worker = {*classifier, RayLattice(tolerance), {}, {}};
    PLUMBLINE_TRY(arena.take_top(worker.heights, kMostHeights, "rays"));
  }
  auto store = CrossingStore::create(field.grid, arena);
  PLUMBLINE_TRY(store);
  Box3f bounds = field.cloud->bounds();
  bounds.low -= Vec3f::Constant(std::max(field.widths.usual, field.widths.widest));
  bounds.high += Vec3f::Constant(std::max(field.widths.usual, field.widths.widest));
  PLUMBLINE_TRY(for_each_tile(*store, threads, progress, [&](std::uint32_t tile, std::size_t thread) {
    return shoot_tile(field, bounds, tile, (*workers)[thread], confidence, *store);
  }));
  for (const Worker& worker : *workers) {
    counts.thinned_tiles += worker.counts.thinned_tiles;
    counts.guided += worker.counts.guided;
    counts.interpolated += worker.counts.interpolated;
    for (std::size_t d = 0; d < kRayDecisionCount; ++d) counts.decided[d] += worker.counts.decided[d];
  }
  PLUMBLINE_TRY(store->close(arena));
  return store;
}

}  // namespace plumbline::inline slicer
