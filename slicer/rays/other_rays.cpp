#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "slicer/rays/ray_shooter.hpp"
#include "slicer/rays/tile_loop.hpp"

namespace plumbline::inline slicer {
namespace {

// A sheet is smooth where a second difference of heights is at most so many parts of a layer, or as large as the first difference: between rays an interpolated
// height is off by an eighth of it, which is a sixteenth of a layer or an eighth of a pixel.
constexpr std::int32_t kBend = CrossingHeight::kParts / 2;

constexpr std::uint32_t kSide = CrossingStore::kAroundSide;

/// Where the ray is from ray 0 of its pixel, in eighths of a pixel.
struct Offset {
  std::int32_t x = 0, y = 0;

  explicit Offset(const PrintGrid& grid) {
    x = static_cast<std::int32_t>((grid.ray_x - 0.5F) * 8);
    y = static_cast<std::int32_t>((grid.ray_y - 0.5F) * 8);
  }
};

/// The four rays 0 around another ray, and those next to them.
class Around {
 public:
  /// @param column, row  of the pixel in its tile
  Around(const CrossingStore::RaysAround& rays, std::uint32_t column, std::uint32_t row, Offset offset)
      : own_(&rays[(row + 1) * kSide + column + 1]),
        offset_(offset),
        beside_(offset.x < 0 ? -1 : 1),
        below_(offset.y < 0 ? -1 : 1) {}

  std::size_t crossings() const { return own_->size(); }
  bool are_alike() const { return is_alike(beside_, 0) && is_alike(0, below_) && is_alike(beside_, below_); }
  bool is_smooth(std::size_t i) const {
    for (const int n : {0, 1}) {
      const int row = n * below_;
      if (bends(i, -1, row, 0, row, 1, row) || bends(i, n * beside_, -1, n * beside_, 0, n * beside_, 1)) return false;
    }
    return true;
  }
  CrossingHeight height(std::size_t i) const {
    const std::int32_t x = std::abs(offset_.x), y = std::abs(offset_.y);
    const std::int32_t sum = (8 - y) * ((8 - x) * z(i, 0, 0) + x * z(i, beside_, 0)) +
                             y * ((8 - x) * z(i, 0, below_) + x * z(i, beside_, below_));
    const auto parts = static_cast<std::uint32_t>((sum + 32) / 64);
    return CrossingHeight(parts / CrossingHeight::kParts, parts % CrossingHeight::kParts);
  }

 private:
  const StoredHeights& at(int c, int r) const { return own_[r * static_cast<int>(kSide) + c]; }
  bool is_alike(int c, int r) const { return at(c, r).size() == own_->size(); }
  std::int32_t z(std::size_t i, int c, int r) const { return at(c, r).parts(i); }
  /// Along three rays. Beyond an edge there is no third.
  bool bends(std::size_t i, int c0, int r0, int c1, int r1, int c2, int r2) const {
    if (!is_alike(c0, r0) || !is_alike(c2, r2)) return false;
    const std::int32_t before = z(i, c0, r0), here = z(i, c1, r1), after = z(i, c2, r2);
    return std::abs(before - 2 * here + after) > std::max(kBend, std::abs(after - before) / 2);
  }

  const StoredHeights* own_;
  Offset offset_;
  int beside_, below_;  ///< column and row of the rays on the other side
};

class OtherRays {
 public:
  [[nodiscard]] static Expected<OtherRays> create(const RayField& field, Arena& arena) {
    const auto classifier = RayClassifier::create(field, arena);
    PLUMBLINE_TRY(classifier);
    OtherRays rays(*classifier, field.grid);
    PLUMBLINE_TRY(arena.take_top(rays.heights_, kMostHeights, "rays"));
    return rays;
  }

  /// @param around  the tile's rays 0
  Status shoot_tile(std::uint32_t tile, const CrossingStore::RaysAround& around, CrossingStore& store) {
    const PrintGrid& grid = classifier_.grid();
    column_ = tile % store.tile_columns() * kTileSide;
    row_ = tile / store.tile_columns() * kTileSide;
    has_begun_ = false;
    std::array<std::uint8_t, kRaysPerTile> counts{};
    std::uint32_t used = 0;
    for (std::uint32_t r = 0; r < std::min(kTileSide, grid.rows - row_); ++r) {
      for (std::uint32_t c = 0; c < std::min(kTileSide, grid.columns - column_); ++c) {
        CrossingHeight* const out = &heights_[used];
        const std::uint32_t count = shoot(c, r, Around(around, c, r, offset_), out);
        counts[r * kTileSide + c] = static_cast<std::uint8_t>(count);
        used += count;
      }
    }
    return used > 0 ? store.put(tile, counts, heights_.first(used)) : Status{};
  }

 private:
  OtherRays(const RayClassifier& classifier, const PrintGrid& grid) : classifier_(classifier), offset_(grid) {}

  RayClassifier& classifier() {
    if (!has_begun_) classifier_.begin_tile(column_, row_);
    has_begun_ = true;
    return classifier_;
  }
  /// @returns number of crossings
  std::uint32_t shoot(std::uint32_t c, std::uint32_t r, const Around& around, CrossingHeight* out) {
    std::uint32_t count = 0;
    if (!around.are_alike() || !follow(c, r, around, out, count)) {
      count = 0;
      for (const RayCrossing& crossing : classifier().ray(column_ + c, row_ + r).crossings) {
        add_height(height_of(crossing.depth, classifier_.grid()), out, count);
      }
    }
    end_heights(classifier_.grid(), out, count);
    return count;
  }
  /// Follows the sheets of the rays around: interpolates where they are smooth, else looks for the sheet near there.
  bool follow(std::uint32_t c, std::uint32_t r, const Around& around, CrossingHeight* out, std::uint32_t& count) {
    for (std::size_t i = 0; i < around.crossings(); ++i) {
      CrossingHeight height = around.height(i);
      if (!around.is_smooth(i)) {
        const PrintGrid& grid = classifier_.grid();
        const float layers = static_cast<float>(height.layer()) +
                             (static_cast<float>(height.part()) + 0.5F) / float{CrossingHeight::kParts} - 0.5F;
        const auto depth = classifier().sheet_near(column_ + c, row_ + r, layers * grid.layer_height_mm, i % 2 == 0);
        if (!depth) return false;
        height = height_of(*depth, grid);
        // Sheets that cross each other are not followed.
        if (count > 0 && height.layer() < out[count - 1].layer()) return false;
      }
      add_height(height, out, count);
    }
    return true;
  }

  RayClassifier classifier_;
  std::span<CrossingHeight> heights_;
  Offset offset_;
  std::uint32_t column_ = 0, row_ = 0;  ///< of the tile's first ray
  bool has_begun_ = false;              ///< the classifier has begun the tile
};

}  // namespace

Expected<CrossingStore> shoot_other_rays(const RayField& field, const CrossingStore& base, std::uint32_t threads,
                                         Arena& arena, const StageProgress& progress) {
  const ArenaScope scope(arena);
  const auto workers = arena.take_top<OtherRays>(threads, "rays");
  PLUMBLINE_TRY(workers);
  for (OtherRays& worker : *workers) {
    const auto made = OtherRays::create(field, arena);
    PLUMBLINE_TRY(made);
    worker = *made;
  }
  auto store = CrossingStore::create(field.grid, arena);
  PLUMBLINE_TRY(store);
  PLUMBLINE_TRY(for_each_tile(*store, threads, progress, [&](std::uint32_t tile, std::size_t thread) {
    CrossingStore::RaysAround around;
    return base.rays_around(tile, around) ? (*workers)[thread].shoot_tile(tile, around, *store) : Status();
  }));
  PLUMBLINE_TRY(store->close(arena));
  return store;
}

}  // namespace plumbline::inline slicer
