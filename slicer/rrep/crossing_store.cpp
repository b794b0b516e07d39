#include "slicer/rrep/crossing_store.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <numeric>

#include "slicer/core/numbers/mib.hpp"

namespace plumbline::inline slicer {

CrossingHeight height_of(float depth, const PrintGrid& grid) {
  const float above = depth / grid.layer_height_mm - 0.5F;
  const float k = std::ceil(above);
  const float part = std::ceil((above - k + 1) * CrossingHeight::kParts) - 1;
  return CrossingHeight(static_cast<std::uint32_t>(std::clamp(k, 0.0F, static_cast<float>(grid.layers))),
                        k < 0 ? 0 : static_cast<std::uint32_t>(std::clamp(part, 0.0F, CrossingHeight::kParts - 1.0F)));
}

Expected<CrossingStore> CrossingStore::create(const PrintGrid& grid, Arena& arena) {
  CrossingStore store;
  store.grid_ = grid;
  store.part_bits_ = StoredHeights::part_bits(grid);
  store.bottom_mark_ = arena.bottom_mark();
  store.tile_columns_ = (grid.columns + kTileSide - 1) / kTileSide;
  store.tile_rows_ = (grid.rows + kTileSide - 1) / kTileSide;
  PLUMBLINE_TRY(arena.take_bottom(store.directory_, std::size_t{store.tile_columns_} * store.tile_rows_, "R-Rep"));
  std::fill(store.directory_.begin(), store.directory_.end(), kEmpty);
  const std::span<std::byte> room = arena.free_room();
  store.data_ = {reinterpret_cast<std::uint16_t*>(room.data()),
                 std::min<std::size_t>(room.size() / sizeof(std::uint16_t), kEmpty - 1)};
  return store;
}

Status CrossingStore::put(std::uint32_t tile, std::span<const std::uint8_t> counts,
                          std::span<const CrossingHeight> heights) {
  const auto need = static_cast<std::uint32_t>(kRaysPerTile / 2 + heights.size());
  const std::uint32_t at = std::atomic_ref(used_).fetch_add(need, std::memory_order_relaxed);
  if (std::uint64_t{at} + need > data_.size()) {
    return fail(
        ErrorCode::kOutOfMemory,
        "R-Rep: the crossings of the rays need more than the %.1f MiB that the arena has left for them.\tUse a larger "
        "arena, a coarser grid or a smaller object",
        mib(data_.size_bytes()));
  }
  std::memcpy(&data_[at], counts.data(), kRaysPerTile);
  std::ranges::transform(heights, data_.begin() + at + kRaysPerTile / 2,
                         [&](CrossingHeight height) { return StoredHeights::stored(height, part_bits_); });
  directory_[tile] = at;
  return {};
}

Expected<CrossingStore::RowRoom> CrossingStore::take_row_room(Arena& arena) const {
  RowRoom room;
  PLUMBLINE_TRY(arena.take_top(room.rays, grid_.columns, "R-Rep"));
  PLUMBLINE_TRY(arena.take_top(room.reads, tile_columns_, "R-Rep"));
  PLUMBLINE_TRY(arena.take_top(room.writes, tile_columns_, "R-Rep"));
  return room;
}

StoredHeights CrossingStore::ray(std::uint32_t column, std::uint32_t row) const {
  const std::uint32_t at = directory_[row / kTileSide * tile_columns_ + column / kTileSide];
  if (at == kEmpty) return {};
  const auto* const counts = reinterpret_cast<const std::uint8_t*>(&data_[at]);
  const std::uint32_t number = row % kTileSide * kTileSide + column % kTileSide;
  const std::uint32_t before = std::accumulate(counts, counts + number, 0U);
  return {data_.subspan(at + kRaysPerTile / 2 + before, counts[number]), part_bits_};
}

bool CrossingStore::rays_around(std::uint32_t tile, RaysAround& rays) const {
  rays.fill({});
  const auto x = static_cast<std::int64_t>(tile % tile_columns_), y = static_cast<std::int64_t>(tile / tile_columns_);
  bool any = false;
  for (std::int64_t dy = -1; dy <= 1; ++dy) {
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      if (x + dx < 0 || x + dx >= tile_columns_ || y + dy < 0 || y + dy >= tile_rows_) continue;
      const std::uint32_t at = directory_[static_cast<std::size_t>((y + dy) * tile_columns_ + x + dx)];
      if (at == kEmpty) continue;
      const auto* const counts = reinterpret_cast<const std::uint8_t*>(&data_[at]);
      std::size_t begin = at + kRaysPerTile / 2;
      for (std::uint32_t i = 0; i < kRaysPerTile; begin += counts[i++]) {
        const std::int64_t c = dx * kTileSide + i % kTileSide + 1, r = dy * kTileSide + i / kTileSide + 1;
        if (counts[i] == 0 || c < 0 || c >= kAroundSide || r < 0 || r >= kAroundSide) continue;
        rays[static_cast<std::size_t>(r * kAroundSide + c)] = {data_.subspan(begin, counts[i]), part_bits_};
        any = true;
      }
    }
  }
  return any;
}

void CrossingStore::move_by(std::ptrdiff_t bytes) {
  const auto moved = [bytes]<class T>(std::span<T> block) {
    return std::span<T>(reinterpret_cast<T*>(reinterpret_cast<std::byte*>(block.data()) + bytes), block.size());
  };
  directory_ = moved(directory_);
  data_ = moved(data_);
  bottom_mark_ += static_cast<std::size_t>(bytes);
}

void CrossingStore::put_last(CrossingStore& first, std::span<CrossingStore> others, const Arena& arena) {
  auto* const begin = reinterpret_cast<std::byte*>(first.directory_.data());
  const std::size_t own = others.front().bottom_mark_ - first.bottom_mark_;
  const std::size_t all = arena.bottom_mark() - first.bottom_mark_;
  std::rotate(begin, begin + own, begin + all);
  first.move_by(static_cast<std::ptrdiff_t>(all - own));
  for (CrossingStore& other : others) other.move_by(-static_cast<std::ptrdiff_t>(own));
}

std::uint32_t CrossingStore::crossings() const {
  const auto empty = static_cast<std::size_t>(std::count(directory_.begin(), directory_.end(), kEmpty));
  return used_ - static_cast<std::uint32_t>((directory_.size() - empty) * kRaysPerTile / 2);
}

Status CrossingStore::move_to_top(Arena& arena) {
  std::span<std::uint16_t> data;
  std::span<std::uint32_t> directory;
  const std::size_t mark = arena.top_mark();
  PLUMBLINE_TRY(arena.take_top(data, used_, "R-Rep"));
  if (const auto taken = arena.take_top(directory, directory_.size(), "R-Rep"); !taken) {
    arena.release_top(mark);
    return taken;
  }
  std::copy_n(data_.begin(), used_, data.begin());
  std::ranges::copy(directory_, directory.begin());
  data_ = data;
  directory_ = directory;
  is_at_top_ = true;
  arena.release_bottom(bottom_mark_);
  return {};
}

Expected<RRep> CrossingStore::sort(CrossingStore& store, Arena& arena) {
  const ArenaScope scope(arena);
  const PrintGrid& grid = store.grid_;
  // The R-Rep stays until the print ends, so it belongs at the bottom: the store goes out of its way.
  if (!store.is_at_top_) PLUMBLINE_TRY(store.move_to_top(arena));
  std::span<std::uint32_t> first, packed;
  const auto room = store.take_row_room(arena);
  PLUMBLINE_TRY(room);

  PLUMBLINE_TRY(arena.take_bottom(first, std::size_t{grid.layers} + 1, "R-Rep"));
  std::fill(first.begin(), first.end(), 0);
  store.for_each_row(*room, [&](std::uint32_t, std::span<const RayRef> rays) {
    for (const RayRef& ray : rays) {
      const auto crossings = ray.crossings();
      if (crossings.empty()) continue;
      // Layers where the ray leaves minus those where it enters. One that does not leave goes on to the top.
      std::uint32_t inside = 0;
      for (std::size_t i = 0; i < crossings.size(); ++i) {
        ++first[crossings.layer(i) + std::size_t{1}];
        inside = crossings.layer(i) - inside;
      }
      store.section_pixels_ += crossings.size() % 2 == 0 ? inside : grid.layers - inside;
    }
  });
  for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
  PLUMBLINE_TRY(arena.take_bottom(packed, first.back(), "R-Rep"));
  const CrossingPacking packing(grid);
  // first[k] is where the layer's next crossing goes; after the last one it has become first[k + 1].
  store.for_each_row(*room, [&](std::uint32_t row, std::span<const RayRef> rays) {
    std::uint32_t at = row * grid.columns;
    for (const RayRef& ray : rays) {
      const auto crossings = ray.crossings();
      for (std::size_t i = 0; i < crossings.size(); ++i) {
        packed[first[crossings.layer(i)]++] = packing.packed(at, crossings.part(i));
      }
      ++at;
    }
  });
  for (std::size_t k = first.size() - 1; k > 0; --k) first[k] = first[k - 1];
  first[0] = 0;
  return RRep{.grid = grid, .first = first, .packed = packed};
}

}  // namespace plumbline::inline slicer
