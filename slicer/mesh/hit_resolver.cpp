#include "slicer/mesh/hit_resolver.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <optional>
#include <utility>

#include "slicer/core/loop_progress.hpp"
#include "slicer/mesh/mesh_ray.hpp"
#include "slicer/mesh/negative_cut.hpp"
#include "slicer/mesh/open/open_rays.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "mesh";
constexpr std::size_t kRoom = std::size_t{kRaysPerTile} * kMostRayCrossings;
/// Cells between the samples that look for solid parts that the hits miss.
constexpr float kSearchStep = 4;
/// Cells between the sections that are compared with the one at the base plane.
constexpr float kSectionCells = 2;
/// Samples of a stretch for solid parts, at most.
constexpr std::uint32_t kMostSearched = 16;

/// Whether the winding number finds solid where the hits are sure that there is none. The other way round the hits are right: faces
/// that are flipped make the winding number too small near them.
bool misses_solid(const MeshField& mesh, const MeshRay& field, const RayHits& ray, const PrintGrid& grid) {
  bool found = false;
  const std::uint32_t clear = mesh.layers_in(1, grid.layer_height_mm);
  const std::uint32_t least_step = mesh.layers_in(kSearchStep, grid.layer_height_mm);
  for_each_stretch(ray, grid.layers, [&](const RayStretch& stretch) {
    if (!stretch.is_sure() || stretch.is_solid()) return;
    const std::uint32_t step = std::max(least_step, (stretch.end - stretch.begin) / kMostSearched);
    for (std::uint32_t k = stretch.begin + clear; !found && k + clear < stretch.end; k += step) {
      found = field.inside(k, stretch.from_all_above);
    }
  });
  return found;
}

/// The pixel in the middle of a tile, or the last one.
std::pair<std::uint32_t, std::uint32_t> middle_of_tile(std::uint32_t column, std::uint32_t row, const PrintGrid& grid) {
  constexpr std::uint32_t kMiddle = kTileSide / 2;
  return {std::min(column * kTileSide + kMiddle, grid.columns - 1), std::min(row * kTileSide + kMiddle, grid.rows - 1)};
}

/// Heights of the crossings of a ray: those of the last hit of the layer that enters or exits as the crossing does, or exits or enters if it
/// is of a negative volume. Where the winding number alone decided, at the layer's underside.
/// @param layers  at which the ray becomes solid, then empty, and so on
void take_heights(std::span<const std::uint16_t> layers, const RayHits& solid, const RayHits& negative,
                  std::span<CrossingHeight> heights) {
  std::size_t at = 0, at_negative = 0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const bool exits = i % 2 == 1;
    heights[i] = CrossingHeight(layers[i]);
    const auto pass = [&](const RayHits& hits, std::size_t& next, bool turned) {
      for (; next < hits.size() && hits.layer(next) <= layers[i]; ++next) {
        const PackedHit& hit = hits.all[next];
        if (hits.layer(next) == layers[i] && hits.packing.exits(hit) == (exits != turned)) {
          heights[i] = hits.packing.height(hit);
        }
      }
    };
    pass(negative, at_negative, true);
    pass(solid, at, false);
  }
}

/// What one thread works with.
struct Worker {
  std::span<CrossingHeight> room;  ///< kRaysPerTile * kMostRayCrossings
  std::optional<OpenRays> open;    ///< of a mesh that is not closed
  MeshCounts counts;
};

/// Blocks of tiles, so that open rays can be decided by others that are far.
class Resolver {
 public:
  Resolver(const HitList& hits, const PrintGrid& grid, CrossingStore& store, LoopProgress& progress)
      : hits_(hits), grid_(grid), store_(store), progress_(progress) {}

  std::uint32_t block_columns() const { return (hits_.tile_columns() + kSide - 1) / kSide; }
  std::uint32_t blocks() const { return block_columns() * ((hits_.tile_rows() + kSide - 1) / kSide); }

  /// Stores the crossings of a block, unless the caller has cancelled.
  Status store_block(std::uint32_t block, Worker& worker) const {
    const std::uint32_t first_column = block % block_columns() * kSide;
    const std::uint32_t first_row = block / block_columns() * kSide;
    if (is_bare(first_column, first_row, worker)) return {};
    if (worker.open) worker.open->begin(hits_, first_column * kTileSide, first_row * kTileSide);
    for (std::uint32_t r = first_row; r < std::min(first_row + kSide, hits_.tile_rows()); ++r) {
      for (std::uint32_t c = first_column; c < std::min(first_column + kSide, hits_.tile_columns()); ++c) {
        if (!progress_.step(r * hits_.tile_columns() + c)) return {};
        PLUMBLINE_TRY(store_tile(c, r, worker));
      }
    }
    return {};
  }

 private:
  static constexpr std::uint32_t kSide = OpenRays::kSide / kTileSide;  ///< tiles

  /// Whether a block has no hits, and no ray that is asked all the same. Then no tile of it needs a look, not even one of its progress.
  bool is_bare(std::uint32_t first_column, std::uint32_t first_row, const Worker& worker) const {
    for (std::uint32_t r = first_row; r < std::min(first_row + kSide, hits_.tile_rows()); ++r) {
      for (std::uint32_t c = first_column; c < std::min(first_column + kSide, hits_.tile_columns()); ++c) {
        if (worker.open && worker.open->is_doubtful(c, r)) return false;
        if (!hits_.of_tile(r * hits_.tile_columns() + c).empty()) return false;
      }
    }
    return true;
  }

  Status store_tile(std::uint32_t tile_column, std::uint32_t tile_row, Worker& worker) const {
    const std::uint32_t tile = tile_row * hits_.tile_columns() + tile_column;
    auto hits = hits_.of_tile(tile);
    auto negative = hits_.negative_of_tile(tile);
    if (hits.empty() && !worker.open) return {};
    std::array<std::uint8_t, kRaysPerTile> counted{};
    std::size_t used = 0;
    for (std::uint32_t i = 0; i < kRaysPerTile; ++i) {
      const auto ray = hits_.take_ray(hits, i);
      const RayHits cut = hits_.take_ray(negative, i);
      const std::uint32_t column = tile_column * kTileSide + i % kTileSide;
      const std::uint32_t row = tile_row * kTileSide + i / kTileSide;
      const bool open = worker.open && worker.open->is_open(column, row);
      if (ray.empty() && !open) continue;
      std::array<std::uint16_t, kMostRayCrossings> layers, uncut_layers;
      RayToggles toggles(layers), uncut(uncut_layers);
      RayToggles& solids = cut.empty() ? toggles : uncut;
      if (open) {
        worker.open->decide(column, row, solids);
      } else {
        for_each_stretch(ray, grid_.layers,
                         [&](const RayStretch& stretch) { solids.set(stretch.begin, stretch.is_solid()); });
      }
      if (!cut.empty()) cut_negative(std::span(uncut_layers).first(uncut.count()), ray, cut.all, grid_.layers, toggles);
      worker.counts.rays += ray.empty() ? 0 : 1;
      worker.counts.broken_rays += winding_sum(ray) != 0 ? 1 : 0;
      worker.counts.decided_rays += open ? 1 : 0;
      worker.counts.crowded_rays += toggles.crowded() || uncut.crowded() ? 1 : 0;
      counted[i] = static_cast<std::uint8_t>(toggles.count());
      take_heights(std::span(layers).first(toggles.count()), ray, cut, worker.room.subspan(used));
      used += toggles.count();
    }
    return used > 0 ? store_.put(tile, counted, worker.room.first(used)) : Status{};
  }

  const HitList& hits_;
  const PrintGrid& grid_;
  CrossingStore& store_;
  LoopProgress& progress_;
};

Expected<std::span<Worker>> make_workers(const PrintGrid& grid, const MeshField* field, std::uint32_t threads,
                                         Arena& arena) {
  const auto workers = arena.take_top<Worker>(threads, kStage);
  PLUMBLINE_TRY(workers);
  for (Worker& worker : *workers) {
    worker = {};
    const auto room = arena.take_top<CrossingHeight>(kRoom, kStage);
    PLUMBLINE_TRY(room);
    worker.room = *room;
    if (field == nullptr) continue;
    const auto open = OpenRays::create(*field, grid, arena);
    PLUMBLINE_TRY(open);
    worker.open = *open;
  }
  return workers;
}

}  // namespace

Status find_doubtful(MeshField& field, const HitList& hits, const PrintGrid& grid, std::uint32_t threads, Arena& arena,
                     const StageProgress& progress) {
  const ArenaScope scope(arena);
  const auto rays = arena.take_top<MeshRay>(threads, kStage);
  PLUMBLINE_TRY(rays);
  for (MeshRay& ray : *rays) {
    const auto made = MeshRay::create(field, grid, arena);
    PLUMBLINE_TRY(made);
    ray = *made;
  }
  const std::uint32_t rows = field.end_row - field.first_row;
  const std::uint32_t columns = field.end_column - field.first_column;
  LoopProgress loop(progress, rows * columns);
#pragma omp parallel for schedule(dynamic, 16) num_threads(static_cast <int>(threads))
  for (std::uint32_t i = 0; i < rows * columns; ++i) {
    if (!loop.step(i)) continue;
    const std::uint32_t tile_column = field.first_column + i % columns;
    const std::uint32_t tile_row = field.first_row + i / columns;
    const auto [column, row] = middle_of_tile(tile_column, tile_row, grid);
    const RayHits on_ray = hits.of_ray(column, row);
    MeshRay& ray = (*rays)[static_cast<std::size_t>(omp_get_thread_num())];
    ray.begin(column, row, on_ray);
    if (!misses_solid(field, ray, on_ray, grid)) continue;
    for (std::uint32_t r = std::max(tile_row, 1U) - 1; r <= std::min(tile_row + 1, hits.tile_rows() - 1); ++r) {
      for (std::uint32_t c = std::max(tile_column, 1U) - 1; c <= std::min(tile_column + 1, hits.tile_columns() - 1);
           ++c) {
        std::atomic_ref(field.doubtful.row(r)[c / 64])
            .fetch_or(std::uint64_t{1} << (c % 64), std::memory_order_relaxed);
      }
    }
  }
  if (loop.stopped()) return fail(ErrorCode::kCancelled, "cancelled while the mesh was sliced");
  return {};
}

Expected<bool> mirror_open_underside(MeshField& field, const HitList& hits, const PrintGrid& grid, float height,
                                     Arena& arena) {
  const ArenaScope scope(arena);
  auto ray = MeshRay::create(field, grid, arena);
  PLUMBLINE_TRY(ray);
  const auto layer = static_cast<std::uint32_t>(std::max(0.0F, height / grid.layer_height_mm));
  const bool open = is_underside_open([&](std::uint32_t section) {
    const std::uint32_t k = layer + section * field.layers_in(kSectionCells, grid.layer_height_mm);
    std::uint32_t count = 0;
    for (std::uint32_t r = field.first_row; r < field.end_row; ++r) {
      for (std::uint32_t c = field.first_column; c < field.end_column; ++c) {
        const auto [column, row] = middle_of_tile(c, r, grid);
        const RayHits on_ray = hits.of_ray(column, row);
        if (on_ray.empty()) continue;
        ray->begin(column, row, on_ray);
        if (section == 0) {
          count += ray->is_open_at(height) ? 1 : 0;
          continue;
        }
        for_each_stretch(on_ray, grid.layers, [&](const RayStretch& stretch) {
          if (stretch.begin <= k && k < stretch.end) count += ray->inside(k, stretch.from_all_above) ? 1 : 0;
        });
      }
    }
    return count;
  });
  if (open) field.base = height;
  return open;
}

std::size_t resolve_bytes(std::uint32_t threads, const MeshField* field) {
  return Arena::rounded(threads * sizeof(Worker)) + threads * (Arena::rounded(kRoom * sizeof(CrossingHeight)) +
                                                               (field == nullptr ? 0 : OpenRays::bytes_needed(*field)));
}

Expected<CrossingStore> resolve_hits(const HitList& hits, const PrintGrid& grid, const MeshField* field,
                                     std::uint32_t threads, Arena& arena, const StageProgress& progress,
                                     MeshCounts& counts) {
  const auto workers = make_workers(grid, field, threads, arena);
  PLUMBLINE_TRY(workers);
  auto store = CrossingStore::create(grid, arena);
  PLUMBLINE_TRY(store);
  LoopProgress loop(progress, hits.tile_columns() * hits.tile_rows());
  const Resolver resolver(hits, grid, *store, loop);
  const std::uint32_t blocks = resolver.blocks();
  std::atomic<bool> failed = false;
  Status status;
#pragma omp parallel for schedule(dynamic, 1) num_threads(static_cast <int>(threads))
  for (std::uint32_t block = 0; block < blocks; ++block) {
    if (failed.load(std::memory_order_relaxed) || loop.stopped()) continue;
    const Status stored = resolver.store_block(block, (*workers)[static_cast<std::size_t>(omp_get_thread_num())]);
    if (!stored) {
#pragma omp critical
      status = stored;
      failed = true;
    }
  }
  PLUMBLINE_TRY(status);
  if (loop.stopped()) return fail(ErrorCode::kCancelled, "cancelled while the mesh was sliced");
  for (const Worker& worker : *workers) {
    counts.rays += worker.counts.rays;
    counts.broken_rays += worker.counts.broken_rays;
    counts.decided_rays += worker.counts.decided_rays;
    counts.asked_rays += worker.open ? worker.open->asked() : 0;
    counts.crowded_rays += worker.counts.crowded_rays;
  }
  PLUMBLINE_TRY(store->close(arena));
  return store;
}

}  // namespace plumbline::inline slicer
