#include "slicer/mesh/hit_resolver.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "slicer/core/loop_progress.hpp"
#include "slicer/mesh/ray_solids.hpp"

namespace plumbline {
namespace {

constexpr std::uint32_t kRaysPerTile = kTileSide * kTileSide;
/// A stretch this many cells long is judged by the winding number in its middle.
constexpr float kTrusted = 2;
/// Samples of a stretch, at most. It has no hits, so only where the surface has holes can it change; a winding number costs 1 us.
constexpr std::uint32_t kMostSamples = 24;
/// Cells between the samples that look for solid parts that the hits miss.
constexpr float kSearchStep = 4;

/// The field along one ray.
class RayField {
 public:
  RayField(const MeshField& field, const PrintGrid& grid, std::uint32_t column, std::uint32_t row)
      : field_(field),
        layer_height_(grid.layer_height_mm),
        x_((static_cast<float>(column) + 0.5F) * grid.pitch_x_mm),
        y_((static_cast<float>(row) + 0.5F) * grid.pitch_y_mm) {}

  bool inside(std::uint32_t layer) const {
    return field_.winding->inside({x_, y_, (static_cast<float>(layer) + 0.5F) * layer_height_});
  }
  /// Layers in a number of cells, at least 1.
  std::uint32_t layers_in(float cells) const {
    return static_cast<std::uint32_t>(std::clamp(cells * field_.cell / layer_height_, 1.0F, 65535.0F));
  }

  /// Sets the solid parts of a stretch by samples a cell apart or more, and finds the layer where they change by bisection.
  void decide(const RayStretch& stretch, RayToggles& toggles) const {
    const std::uint32_t length = stretch.end - stretch.begin;
    const std::uint32_t samples = std::clamp(length / layers_in(1), 1U, kMostSamples);
    bool before = false;
    std::uint32_t last = stretch.begin;
    for (std::uint32_t s = 0; s < samples; ++s) {
      const auto layer =
          stretch.begin + static_cast<std::uint32_t>((2 * std::uint64_t{s} + 1) * length / (2 * samples));
      const bool solid = inside(layer);
      toggles.set(s == 0 ? stretch.begin : solid == before ? layer : change(last, layer, before), solid);
      before = solid;
      last = layer;
    }
  }

 private:
  /// The first layer above `low` that is not as there.
  std::uint32_t change(std::uint32_t low, std::uint32_t high, bool at_low) const {
    while (high - low > 1) {
      const std::uint32_t middle = low + (high - low) / 2;
      (inside(middle) == at_low ? low : high) = middle;
    }
    return high;
  }

  const MeshField& field_;
  float layer_height_;
  float x_, y_;
};

/// The hits of ray `ray` at the front of `hits`, which it removes.
std::span<const PackedHit> take_ray(std::span<const PackedHit>& hits, std::uint32_t ray) {
  std::size_t count = 0;
  while (count < hits.size() && hits[count].ray() == ray) ++count;
  const auto taken = hits.first(count);
  hits = hits.subspan(count);
  return taken;
}

/// Whether the winding number finds solid where the hits are sure that there is none. The other way round the hits are right: faces
/// that are flipped make the winding number too small near them.
bool misses_solid(const RayField& field, std::span<const PackedHit> ray, std::uint32_t layers) {
  bool found = false;
  const std::uint32_t clear = field.layers_in(1);
  const std::uint32_t step = field.layers_in(kSearchStep);
  for_each_stretch(ray, layers, [&](const RayStretch& stretch) {
    if (!stretch.is_sure() || stretch.is_solid()) return;
    for (std::uint32_t k = stretch.begin + clear; !found && k + clear < stretch.end; k += step) {
      found = field.inside(k);
    }
  });
  return found;
}

class Resolver {
 public:
  Resolver(const HitList& hits, const PrintGrid& grid, const MeshField* field)
      : hits_(hits), grid_(grid), field_(field) {}

  /// @param room  kRaysPerTile * kMostRayCrossings layers
  Status tile(std::uint32_t tile, std::span<std::uint16_t> room, CrossingStore& store, MeshCounts& counts) const {
    auto hits = hits_.of_tile(tile);
    const bool doubtful =
        field_ != nullptr && field_->doubtful.at(tile % hits_.tile_columns(), tile / hits_.tile_columns());
    if (hits.empty() && !doubtful) return {};
    std::array<std::uint8_t, kRaysPerTile> counted{};
    std::size_t used = 0;
    for (std::uint32_t i = 0; i < kRaysPerTile; ++i) {
      const auto ray = take_ray(hits, i);
      const std::uint32_t column = tile % hits_.tile_columns() * kTileSide + i % kTileSide;
      const std::uint32_t row = tile / hits_.tile_columns() * kTileSide + i / kTileSide;
      if (column >= grid_.columns || row >= grid_.rows || (ray.empty() && !doubtful)) continue;
      RayToggles toggles(room.subspan(used));
      resolve(ray, column, row, doubtful, toggles, counts);
      counted[i] = static_cast<std::uint8_t>(toggles.count());
      used += toggles.count();
    }
    return used > 0 ? store.put(tile, counted, room.first(used)) : Status{};
  }

 private:
  void resolve(std::span<const PackedHit> ray, std::uint32_t column, std::uint32_t row, bool doubtful,
               RayToggles& toggles, MeshCounts& counts) const {
    counts.rays += ray.empty() ? 0 : 1;
    bool decided = false;
    for_each_stretch(ray, grid_.layers, [&](const RayStretch& stretch) {
      if (field_ != nullptr) {
        const RayField field(*field_, grid_, column, row);
        const bool long_gap = !stretch.is_solid() && stretch.end - stretch.begin > field.layers_in(kTrusted);
        if (!stretch.is_sure() || (doubtful && long_gap)) {
          field.decide(stretch, toggles);
          decided = true;
          return;
        }
      }
      toggles.set(stretch.begin, stretch.is_solid());
    });
    counts.broken_rays += winding_sum(ray) != 0 ? 1 : 0;
    counts.decided_rays += decided ? 1 : 0;
    counts.crowded_rays += toggles.crowded() ? 1 : 0;
  }

  const HitList& hits_;
  const PrintGrid& grid_;
  const MeshField* field_;
};

}  // namespace

bool find_doubtful(MeshField& field, const HitList& hits, const PrintGrid& grid, const StageProgress& progress) {
  constexpr std::uint32_t kMiddle = kTileSide / 2;
  const std::uint32_t rows = field.end_row - field.first_row;
  const std::uint32_t columns = field.end_column - field.first_column;
  LoopProgress loop(progress, rows * columns);
#pragma omp parallel for schedule(dynamic, 16)
  for (std::uint32_t i = 0; i < rows * columns; ++i) {
    if (!loop.step(i)) continue;
    const std::uint32_t tile_column = field.first_column + i % columns;
    const std::uint32_t tile_row = field.first_row + i / columns;
    const std::uint32_t column = std::min(tile_column * kTileSide + kMiddle, grid.columns - 1);
    const std::uint32_t row = std::min(tile_row * kTileSide + kMiddle, grid.rows - 1);
    const std::uint32_t number = row % kTileSide * kTileSide + column % kTileSide;
    auto in_tile = hits.of_tile(tile_row * hits.tile_columns() + tile_column);
    while (!in_tile.empty() && in_tile.front().ray() < number) in_tile = in_tile.subspan(1);
    if (!misses_solid(RayField(field, grid, column, row), take_ray(in_tile, number), grid.layers)) continue;
    for (std::uint32_t r = std::max(tile_row, 1U) - 1; r <= std::min(tile_row + 1, hits.tile_rows() - 1); ++r) {
      for (std::uint32_t c = std::max(tile_column, 1U) - 1; c <= std::min(tile_column + 1, hits.tile_columns() - 1);
           ++c) {
        std::atomic_ref(field.doubtful.row(r)[c / 64])
            .fetch_or(std::uint64_t{1} << (c % 64), std::memory_order_relaxed);
      }
    }
  }
  return !loop.stopped();
}

Expected<CrossingStore> resolve_hits(const HitList& hits, const PrintGrid& grid, const MeshField* field,
                                     std::uint32_t threads, Arena& arena, const StageProgress& progress,
                                     MeshCounts& counts) {
  constexpr std::size_t kRoom = std::size_t{kRaysPerTile} * kMostRayCrossings;
  const auto rooms = arena.take_top<std::uint16_t>(threads * kRoom, "mesh");
  PLUMBLINE_TRY(rooms);
  const auto partial = arena.take_top<MeshCounts>(threads, "mesh");
  PLUMBLINE_TRY(partial);
  std::fill(partial->begin(), partial->end(), MeshCounts{});
  auto store = CrossingStore::create(grid, arena);
  PLUMBLINE_TRY(store);
  const Resolver resolver(hits, grid, field);
  const std::uint32_t tiles = hits.tile_columns() * hits.tile_rows();
  LoopProgress loop(progress, tiles);
  std::atomic<bool> failed = false;
  Status status;
#pragma omp parallel for schedule(dynamic, 16) num_threads(static_cast <int>(threads))
  for (std::uint32_t tile = 0; tile < tiles; ++tile) {
    if (failed.load(std::memory_order_relaxed) || !loop.step(tile)) continue;
    const auto thread = static_cast<std::size_t>(omp_get_thread_num());
    MeshCounts& own = (*partial)[thread];
    const Status stored = resolver.tile(tile, rooms->subspan(thread * kRoom, kRoom), *store, own);
    if (!stored) {
#pragma omp critical
      status = stored;
      failed = true;
    }
  }
  PLUMBLINE_TRY(status);
  if (loop.stopped()) return fail(ErrorCode::kCancelled, "cancelled while the mesh was sliced");
  for (const MeshCounts& own : *partial) {
    counts.rays += own.rays;
    counts.broken_rays += own.broken_rays;
    counts.decided_rays += own.decided_rays;
    counts.crowded_rays += own.crowded_rays;
  }
  store->close(arena);
  return store;
}

}  // namespace plumbline
