#include "slicer/mesh/open/lone_columns.hpp"

#include <algorithm>
#include <span>

namespace plumbline::inline slicer {
namespace {

/// Columns that are found before they are removed.
constexpr std::uint32_t kMostAtATime = 1024;

struct Column {
  std::uint32_t row, column, crossing;
  auto operator<=>(const Column&) const = default;  // NOLINT(modernize-use-nullptr): compares with literal 0
};

/// Layers of [low, high) in which a ray is solid.
std::uint32_t shared_layers(const StoredHeights& ray, std::uint32_t low, std::uint32_t high) {
  std::uint32_t shared = 0;
  for (std::size_t i = 0; i + 1 < ray.size(); i += 2) {
    const std::uint32_t from = std::max(ray.layer(i), low), to = std::min(ray.layer(i + 1), high);
    if (from < to) shared += to - from;
  }
  return shared;
}

/// Whether each of the eight rays around a pixel is hollow in more than half of [low, high).
bool is_lone(const CrossingStore& store, std::uint32_t column, std::uint32_t row, std::uint32_t low,
             std::uint32_t high) {
  const PrintGrid& grid = store.grid();
  for (std::uint32_t r = row - std::min(row, 1U); r < std::min(row + 2, grid.rows); ++r) {
    for (std::uint32_t c = column - std::min(column, 1U); c < std::min(column + 2, grid.columns); ++c) {
      if (r == row && c == column) continue;
      if (2 * shared_layers(store.ray(c, r), low, high) >= high - low) return false;
    }
  }
  return true;
}

}  // namespace

std::size_t lone_columns_bytes(const PrintGrid& grid) {
  return CrossingStore::row_room_bytes(grid) + Arena::rounded(kMostAtATime * sizeof(Column)) + 3 * Arena::kAlignment;
}

Expected<std::uint32_t> drop_lone_columns(CrossingStore& store, Arena& arena) {
  const ArenaScope scope(arena);
  const auto room = store.take_row_room(arena);
  PLUMBLINE_TRY(room);
  const auto found = arena.take_top<Column>(kMostAtATime, "R-Rep");
  PLUMBLINE_TRY(found);
  std::uint32_t dropped = 0;
  for (std::uint32_t count = kMostAtATime; count == kMostAtATime; dropped += count) {
    count = 0;
    store.for_each_row(*room, [&](std::uint32_t row, std::span<const CrossingStore::RayRef> rays) {
      for (std::uint32_t column = 0; column < rays.size(); ++column) {
        const auto crossings = rays[column].crossings();
        for (std::uint32_t i = 0; i + 1 < crossings.size() && count < kMostAtATime; i += 2) {
          const std::uint32_t low = crossings.layer(i), high = crossings.layer(i + 1);
          if (high - low < kLeastColumnLayers || !is_lone(store, column, row, low, high)) continue;
          (*found)[count++] = {row, column, i};
        }
      }
    });
    if (count == 0) break;
    const auto columns = found->first(count);  // in the order of rows and columns
    store.for_each_row(*room, [&](std::uint32_t row, std::span<CrossingStore::RayRef> rays) {
      for (std::uint32_t column = 0; column < rays.size(); ++column) {
        rays[column].rewrite([&](std::uint32_t i) {
          return !std::ranges::binary_search(columns, Column{row, column, i - i % 2});
        });
      }
    });
  }
  return dropped;
}

}  // namespace plumbline::inline slicer
