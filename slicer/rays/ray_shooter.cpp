#include "slicer/rays/ray_shooter.hpp"

#include <omp.h>

#include <algorithm>
#include <atomic>

namespace plumbline {
namespace {

/// Turns the crossings of one ray into layers. Neighbours with no sampling height between them cancel in pairs.
/// @param evidence  out, of each crossing that is left; room for RayClassifier::kMaxCrossings
/// @returns how many are left
std::uint32_t to_layers(std::span<const RayCrossing> crossings, const PrintGrid& grid, std::uint16_t* out,
                        Evidence* evidence) {
  std::uint32_t count = 0;
  for (const RayCrossing& crossing : crossings) {
    const std::uint32_t layer = layer_of(crossing.depth, grid);
    if (count > 0 && out[count - 1] == layer) {
      --count;
    } else {
      evidence[count] = crossing.evidence;
      out[count++] = static_cast<std::uint16_t>(layer);
    }
  }
  // A crossing above the last sampling height has no effect.
  if (count > 0 && out[count - 1] >= grid.layers) --count;
  return count;
}

}  // namespace

std::size_t RayShooter::bytes_needed(std::uint32_t tile_capacity) {
  return RayClassifier::bytes_needed(tile_capacity) + Arena::rounded(sizeof(RayLattice)) +
         Arena::rounded(sizeof(std::uint16_t) * kRaysPerTile * RayClassifier::kMaxCrossings);
}

Expected<RayShooter> RayShooter::create(const RayField& field, float tolerance, ConfidenceMap* confidence,
                                        std::uint32_t threads, Arena& arena) {
  RayShooter shooter;
  shooter.grid_ = field.grid;
  shooter.confidence_ = confidence;
  shooter.bounds_ = field.cloud->bounds();
  shooter.bounds_.low -= Vec3f::Constant(field.max_radius);
  shooter.bounds_.high += Vec3f::Constant(field.max_radius);
  shooter.threads_ = std::clamp<std::uint32_t>(threads, 1, kMaxThreads);
  for (Worker& worker : std::span(shooter.workers_).first(shooter.threads_)) {
    const auto classifier = RayClassifier::create(field, arena);
    PLUMBLINE_TRY(classifier);
    PLUMBLINE_TRY(arena.take_top(worker.layers, std::size_t{kRaysPerTile} * RayClassifier::kMaxCrossings, "R-Rep"));
    const auto lattice = arena.take_top<RayLattice>(1, "R-Rep");
    PLUMBLINE_TRY(lattice);
    lattice->front() = RayLattice(tolerance);
    worker.classifier = *classifier;
    worker.lattice = lattice->data();
  }
  return shooter;
}

Status RayShooter::shoot_tile(Worker& worker, std::uint32_t tile, CrossingStore& store) const {
  const PrintGrid& grid = grid_;
  const std::uint32_t column = tile % store.tile_columns() * kTileSide;
  const std::uint32_t row = tile / store.tile_columns() * kTileSide;
  const std::uint32_t columns = std::min(kTileSide, grid.columns - column);
  const std::uint32_t rows = std::min(kTileSide, grid.rows - row);
  const Vec2f low(static_cast<float>(column) * grid.pitch_x_mm, static_cast<float>(row) * grid.pitch_y_mm);
  const Vec2f high =
      low + Vec2f(static_cast<float>(columns) * grid.pitch_x_mm, static_cast<float>(rows) * grid.pitch_y_mm);
  if ((low.array() > bounds_.high.head<2>().array()).any() || (high.array() < bounds_.low.head<2>().array()).any()) {
    return {};
  }
  worker.classifier.begin_tile(column, row);
  RayCounts& total = worker.counts;
  total.thinned_tiles += worker.classifier.gatherer().thinned() ? 1 : 0;

  RayLattice& lattice = *worker.lattice;
  const bool whole = columns * rows == kRaysPerTile;
  if (whole) {
    lattice.decide(worker.classifier, column, row);
    total.guided += lattice.guided();
    total.interpolated += lattice.interpolated();
  }
  std::array<std::uint8_t, kRaysPerTile> counts{};
  std::array<Evidence, RayClassifier::kMaxCrossings> evidence{};
  std::uint32_t used = 0;
  for (std::uint32_t r = 0; r < rows; ++r) {
    for (std::uint32_t c = 0; c < columns; ++c) {
      const std::uint32_t at = r * kTileSide + c;
      const TileRay& known = lattice.ray(c, r);
      const ClassifiedRay ray = whole && known.known
                                    ? ClassifiedRay{std::span(known.crossing).first(known.count), known.decision}
                                    : worker.classifier.ray(column + c, row + r);
      const std::uint32_t n = to_layers(ray.crossings, grid, &worker.layers[used], evidence.data());
      for (std::uint32_t i = 0; confidence_ != nullptr && i < n; ++i) {
        confidence_->add(column + c, row + r, worker.layers[used + i], evidence[i]);
      }
      counts[at] = static_cast<std::uint8_t>(n);
      used += n;
      if (ray.decision == RayDecision::kAway) continue;
      ++total.decided[static_cast<std::size_t>(ray.decision)];
    }
  }
  return used > 0 ? store.put(tile, counts, worker.layers.first(used)) : Status{};
}

Expected<RayCounts> RayShooter::shoot(CrossingStore& store, ProgressSink* progress) {
  // One thread shoots all tiles that share a column's winding numbers.
  constexpr std::uint32_t kSide = RayClassifier::kColumnTiles;
  const std::uint32_t across = (store.tile_columns() + kSide - 1) / kSide;
  const std::uint32_t columns = across * ((store.tile_rows() + kSide - 1) / kSide);
  std::atomic<std::uint32_t> done = 0;
  std::atomic<bool> stop = false;
  Status status;
#pragma omp parallel for schedule(dynamic, 2) num_threads(static_cast <int>(threads_))
  for (std::uint32_t column = 0; column < columns; ++column) {
    if (stop.load(std::memory_order_relaxed)) continue;
    const int thread = omp_get_thread_num();
    for (std::uint32_t t = 0; t < kSide * kSide; ++t) {
      const std::uint32_t x = column % across * kSide + t % kSide;
      const std::uint32_t y = column / across * kSide + t / kSide;
      if (x >= store.tile_columns() || y >= store.tile_rows()) continue;
      const Status stored = shoot_tile(workers_[static_cast<std::size_t>(thread)], y * store.tile_columns() + x, store);
      if (!stored) {
#pragma omp critical
        status = stored;
        stop = true;
      }
    }
    const std::uint32_t before = done.fetch_add(1, std::memory_order_relaxed);
    if (progress != nullptr && thread == 0 && before % 4 == 0 &&
        !progress->advance(Stage::kRays, static_cast<double>(before) / columns)) {
      stop = true;
    }
  }
  if (!status) return tl::unexpected<Error>(status.error());
  if (stop) return fail(ErrorCode::kCancelled, "cancelled while shooting rays");
  RayCounts sum;
  for (const Worker& worker : std::span(workers_).first(threads_)) {
    sum.thinned_tiles += worker.counts.thinned_tiles;
    sum.guided += worker.counts.guided;
    sum.interpolated += worker.counts.interpolated;
    for (std::size_t d = 0; d < kRayDecisionCount; ++d) sum.decided[d] += worker.counts.decided[d];
  }
  return sum;
}

}  // namespace plumbline
