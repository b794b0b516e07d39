#include "slicer/rrep/crossing_store.hpp"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

namespace plumbline {
namespace {

constexpr std::uint32_t kTile = CrossingStore::kTile;
constexpr std::uint32_t kRaysPerTile = kTile * kTile;

/// Crossings of one ray as layers, those that no sampling height separates taken out in pairs.
/// @param evidence  RayPerfecter::kMaxCrossings of them, for what each that is left rests on
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
  // What begins or ends above the last layer is never seen.
  if (count > 0 && out[count - 1] >= grid.layers) --count;
  return count;
}

}  // namespace

std::uint32_t layer_of(float depth, const PrintGrid& grid) {
  const float k = std::ceil(depth / grid.layer_height_mm - 0.5F);
  return static_cast<std::uint32_t>(std::clamp(k, 0.0F, static_cast<float>(grid.layers)));
}

Expected<CrossingStore> CrossingStore::create(const PrintGrid& grid, Arena& arena) {
  CrossingStore store;
  store.grid_ = grid;
  store.bottom_mark_ = arena.bottom_mark();
  store.tile_columns_ = (grid.columns + kTile - 1) / kTile;
  store.tile_rows_ = (grid.rows + kTile - 1) / kTile;
  auto directory = arena.take_bottom<std::uint32_t>(std::size_t{store.tile_columns_} * store.tile_rows_, "R-Rep");
  if (!directory) return tl::unexpected<Error>(directory.error());
  store.directory_ = *directory;
  std::fill(store.directory_.begin(), store.directory_.end(), kEmpty);
  const std::size_t room = std::min<std::size_t>(arena.available() / sizeof(std::uint16_t), kEmpty - 1);
  auto data = arena.take_bottom<std::uint16_t>(room / 32 * 32, "R-Rep");
  if (!data) return tl::unexpected<Error>(data.error());
  store.data_ = *data;
  return store;
}

Status CrossingStore::put(std::uint32_t tile, std::span<const std::uint8_t> counts,
                          std::span<const std::uint16_t> layers) {
  const auto need = static_cast<std::uint32_t>(kRaysPerTile / 2 + layers.size());
  const std::uint32_t at = std::atomic_ref(used_).fetch_add(need, std::memory_order_relaxed);
  if (std::uint64_t{at} + need > data_.size()) {
    return fail(
        ErrorCode::kOutOfMemory,
        "R-Rep: the crossings of the rays need more than the %.1f MiB that the arena has left for them. Use a larger "
        "arena, a coarser grid or a smaller object",
        static_cast<double>(data_.size_bytes()) / (1024.0 * 1024.0));
  }
  std::memcpy(&data_[at], counts.data(), kRaysPerTile);
  std::copy(layers.begin(), layers.end(), data_.begin() + at + kRaysPerTile / 2);
  directory_[tile] = at;
  return {};
}

template <class Visit>
void CrossingStore::for_each_crossing(std::span<std::uint32_t> cursor, Visit visit) const {
  // Row after row over the whole grid, so that each layer's pixels come out in ascending order.
  for (std::uint32_t tile_row = 0; tile_row < tile_rows_; ++tile_row) {
    const std::uint32_t* directory = &directory_[std::size_t{tile_row} * tile_columns_];
    for (std::uint32_t t = 0; t < tile_columns_; ++t)
      cursor[t] = directory[t] == kEmpty ? 0 : directory[t] + kRaysPerTile / 2;
    const std::uint32_t rows = std::min(kTile, grid_.rows - tile_row * kTile);
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t t = 0; t < tile_columns_; ++t) {
        if (directory[t] == kEmpty) continue;
        const auto* counts = reinterpret_cast<const std::uint8_t*>(&data_[directory[t]]) + std::size_t{r} * kTile;
        std::uint32_t pixel = (tile_row * kTile + r) * grid_.columns + t * kTile;
        for (std::uint32_t c = 0; c < kTile; ++c, ++pixel) {
          for (std::uint32_t i = 0; i < counts[c]; ++i) visit(data_[cursor[t]++], pixel);
        }
      }
    }
  }
}

Expected<RRep> CrossingStore::sort(CrossingStore& store, Arena& arena) {
  const ArenaScope scope(arena);
  const PrintGrid& grid = store.grid_;
  // What stays until the print ends belongs at the bottom, where the store is: move the store out of its way.
  auto data = arena.take_top<std::uint16_t>(store.used_, "R-Rep");
  if (!data) return tl::unexpected<Error>(data.error());
  auto directory = arena.take_top<std::uint32_t>(store.directory_.size(), "R-Rep");
  if (!directory) return tl::unexpected<Error>(directory.error());
  auto cursor = arena.take_top<std::uint32_t>(store.tile_columns_, "R-Rep");
  if (!cursor) return tl::unexpected<Error>(cursor.error());
  std::copy_n(store.data_.begin(), store.used_, data->begin());
  std::copy(store.directory_.begin(), store.directory_.end(), directory->begin());
  store.data_ = *data;
  store.directory_ = *directory;
  arena.release_bottom(store.bottom_mark_);

  auto first_block = arena.take_bottom<std::uint32_t>(std::size_t{grid.layers} + 1, "R-Rep");
  if (!first_block) return tl::unexpected<Error>(first_block.error());
  std::span<std::uint32_t> first = *first_block;
  std::fill(first.begin(), first.end(), 0);
  store.for_each_crossing(*cursor, [&](std::uint16_t layer, std::uint32_t) { ++first[layer + std::size_t{1}]; });
  for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
  auto pixel_block = arena.take_bottom<std::uint32_t>(first.back(), "R-Rep");
  if (!pixel_block) return tl::unexpected<Error>(pixel_block.error());
  std::span<std::uint32_t> pixel = *pixel_block;
  // first[k] serves as the place of the layer's next crossing; when all stand, it has become first[k + 1].
  store.for_each_crossing(*cursor, [&](std::uint16_t layer, std::uint32_t at) { pixel[first[layer]++] = at; });
  for (std::size_t k = first.size() - 1; k > 0; --k) first[k] = first[k - 1];
  first[0] = 0;
  return RRep{grid, first, pixel};
}

std::size_t RayShooter::bytes_needed(std::uint32_t tile_capacity) {
  return RayPerfecter::bytes_needed(tile_capacity) +
         Arena::rounded(sizeof(std::uint16_t) * kRaysPerTile * RayPerfecter::kMaxCrossings);
}

Expected<RayShooter> RayShooter::create(const RayField& field, std::uint32_t threads, Arena& arena) {
  RayShooter shooter;
  shooter.field_ = field;
  shooter.threads_ = std::clamp<std::uint32_t>(threads, 1, kMaxThreads);
  for (Worker& worker : std::span(shooter.workers_).first(shooter.threads_)) {
    auto perfecter = RayPerfecter::create(*field.cloud, *field.tree, *field.winding, field.grid, field.max_radius,
                                          field.tile_capacity, field.settings, arena);
    if (!perfecter) return tl::unexpected<Error>(perfecter.error());
    auto layers = arena.take_top<std::uint16_t>(std::size_t{kRaysPerTile} * RayPerfecter::kMaxCrossings, "R-Rep");
    if (!layers) return tl::unexpected<Error>(layers.error());
    worker.perfecter = *perfecter;
    worker.layers = *layers;
  }
  return shooter;
}

Status RayShooter::shoot_tile(Worker& worker, std::uint32_t tile, CrossingStore& store) const {
  const PrintGrid& grid = field_.grid;
  const std::uint32_t column = tile % store.tile_columns() * kTile;
  const std::uint32_t row = tile / store.tile_columns() * kTile;
  std::array<std::uint8_t, kRaysPerTile> counts{};
  std::array<Evidence, RayPerfecter::kMaxCrossings> evidence{};
  std::uint32_t used = 0;
  bool begun = false;
  for (std::uint32_t r = 0; r < kTile && row + r < grid.rows; ++r) {
    for (std::uint32_t c = 0; c < kTile && column + c < grid.columns; ++c) {
      if (!field_.interested.at(column + c, row + r)) continue;
      if (!begun) {
        worker.perfecter.begin_tile(column, row);
        begun = true;
        ++worker.counts.passing_tiles;
        worker.counts.thinned_tiles += worker.perfecter.tile_thinned() ? 1 : 0;
      }
      const PerfectRay ray = worker.perfecter.ray(column + c, row + r);
      const std::uint32_t n = to_layers(ray.crossings, grid, &worker.layers[used], evidence.data());
      for (std::uint32_t i = 0; field_.confidence != nullptr && i < n; ++i) {
        field_.confidence->add(column + c, row + r, worker.layers[used + i], evidence[i]);
      }
      counts[r * kTile + c] = static_cast<std::uint8_t>(n);
      used += n;
      ++worker.counts.interested;
      ++worker.counts.decided[static_cast<std::size_t>(ray.decision)];
    }
  }
  return used > 0 ? store.put(tile, counts, worker.layers.first(used)) : Status{};
}

Expected<RayCounts> RayShooter::shoot(CrossingStore& store, ProgressSink* progress) {
  // Tiles that share a column's winding numbers go to the same thread, one after another.
  constexpr std::uint32_t kSide = RayPerfecter::kColumnSide / kTile;
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
    sum.passing_tiles += worker.counts.passing_tiles;
    sum.interested += worker.counts.interested;
    sum.thinned_tiles += worker.counts.thinned_tiles;
    for (std::size_t d = 0; d < kRayDecisionCount; ++d) sum.decided[d] += worker.counts.decided[d];
  }
  return sum;
}

}  // namespace plumbline
