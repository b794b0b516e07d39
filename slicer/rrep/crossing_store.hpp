#pragma once
/// Collects the crossings of all rays and sorts them into the R-Rep.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// The heights of a ray's crossings in 16 bits each: layer, and below it as much of the height within the layer as there is room for,
/// 5 bits where an object has 1,025 to 2,048 layers. Upwards.
class StoredHeights {
 public:
  StoredHeights() = default;
  StoredHeights(std::span<const std::uint16_t> heights, unsigned part_bits)
      : heights_(heights), part_bits_(part_bits) {}
  static unsigned part_bits(const PrintGrid& grid) {
    return std::min(CrossingHeight::kBits, 16 - static_cast<unsigned>(std::bit_width(grid.layers - 1)));
  }
  static std::uint16_t stored(CrossingHeight height, unsigned part_bits) {
    return static_cast<std::uint16_t>(height.layer() << part_bits | height.part(part_bits));
  }

  std::size_t size() const { return heights_.size(); }
  bool empty() const { return heights_.empty(); }
  std::uint32_t layer(std::size_t i) const { return static_cast<std::uint32_t>(heights_[i]) >> part_bits_; }
  std::uint32_t part(std::size_t i) const {
    return CrossingHeight::part_of(heights_[i] % (1U << part_bits_), part_bits_);
  }
  /// In parts of a layer, CrossingHeight::kParts.
  std::int32_t parts(std::size_t i) const {
    return static_cast<std::int32_t>(layer(i) * CrossingHeight::kParts + part(i));
  }

 private:
  std::span<const std::uint16_t> heights_;
  unsigned part_bits_ = 0;
};

/// Crossings in the order in which the rays deliver them: per tile 64 counts of one byte, then two bytes a crossing. Tiles are
/// stored at the bottom of the arena in the order in which the threads finish; a directory says where each begins.
class CrossingStore {
 public:
  static constexpr std::uint32_t kEmpty = 0xFFFFFFFFU;

  /// Takes the directory. Until close() the crossings use all that is left of the arena, from which nothing must be taken.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<CrossingStore> create(const PrintGrid& grid, Arena& arena);

  std::uint32_t tile_columns() const { return tile_columns_; }
  std::uint32_t tile_rows() const { return tile_rows_; }

  /// Stores a tile. Thread-safe; call it once a tile.
  /// @param counts  number of crossings of each of its 64 rays, row by row
  /// @param heights  of the crossings, ray after ray, upwards
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] Status put(std::uint32_t tile, std::span<const std::uint8_t> counts,
                           std::span<const CrossingHeight> heights);

  const PrintGrid& grid() const { return grid_; }

  /// The crossings of one ray. They may be rewritten, but not become more.
  class RayRef {
   public:
    StoredHeights crossings() const { return {{read_, *count_}, part_bits_}; }
    /// Leaves the crossings for whose number keeps() is true.
    template <class Keeps>
    void rewrite(Keeps keeps) {
      const std::uint32_t before = *count_;
      *count_ = 0;
      for (std::uint32_t i = 0; i < before; ++i) {
        if (!keeps(i)) continue;
        *(*write_)++ = read_[i];
        ++*count_;
      }
    }

   private:
    friend class CrossingStore;
    std::uint8_t* count_ = nullptr;
    const std::uint16_t* read_ = nullptr;
    std::uint16_t** write_ = nullptr;  ///< where the next crossing of the tile is written
    unsigned part_bits_ = 0;
  };

  /// Work space of for_each_row().
  struct RowRoom {
    std::span<RayRef> rays;
    std::span<std::uint16_t*> reads, writes;  ///< of each tile
  };
  static std::size_t row_room_bytes(const PrintGrid& grid) {
    return grid.columns * (sizeof(RayRef) + 2 * sizeof(void*));
  }
  /// Takes row_room_bytes() from the top of the arena.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] Expected<RowRoom> take_row_room(Arena& arena) const;

  /// Calls `visit(row, rays)` for each row of the grid, in order, with one RayRef a column; not for rows whose tiles have no crossing, as most
  /// of a panel's. A visitor that rewrites a ray must rewrite all rays.
  template <class Visit>
  void for_each_row(const RowRoom& room, Visit visit);

  /// The crossings of the ray of a pixel.
  StoredHeights ray(std::uint32_t column, std::uint32_t row) const;

  /// Rays of a tile and those around it: one more on each side.
  static constexpr std::uint32_t kAroundSide = kTileSide + 2;
  using RaysAround = std::array<StoredHeights, kAroundSide * kAroundSide>;
  /// @param rays  out, row by row from the ray above the first and left of it; empty beyond the grid
  /// @returns whether any has a crossing
  bool rays_around(std::uint32_t tile, RaysAround& rays) const;

  std::size_t bytes() const { return directory_.size_bytes() + std::size_t{used_} * sizeof(std::uint16_t); }
  std::uint32_t crossings() const;  ///< of all rays

  /// Takes the memory that the crossings use. Call it after the last put().
  /// @retval ErrorCode::kOutOfMemory  only in an arena that refuses a block
  [[nodiscard]] Status close(Arena& arena) { return arena.take_bottom(data_, used_, "R-Rep"); }

  /// Lets the first of the newest blocks at the bottom of the arena be the last: the stores after it move down.
  /// @param first   a store at the bottom
  /// @param others  all that was taken since, in their order
  static void put_last(CrossingStore& first, std::span<CrossingStore> others, const Arena& arena);
  /// Moves the store from the bottom of the arena, where it must be the newest block, to the top.
  /// @retval ErrorCode::kOutOfMemory  there is no room for two of it; it is unchanged
  [[nodiscard]] Status move_to_top(Arena& arena);
  /// Sorts all crossings by layer, into the R-Rep at the bottom of the arena. The store moves to the top first if it is not there, so release
  /// all else there before. It also counts section_pixels().
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<RRep> sort(CrossingStore& store, Arena& arena);
  /// Of all layers together. Those of the masks, if they are neither opened nor closed.
  std::uint64_t section_pixels() const { return section_pixels_; }

 private:
  void move_by(std::ptrdiff_t bytes);

  PrintGrid grid_;
  std::uint32_t tile_columns_ = 0;
  std::uint32_t tile_rows_ = 0;
  std::size_t bottom_mark_ = 0;
  bool is_at_top_ = false;
  std::span<std::uint32_t> directory_;  ///< where each tile begins, in units of 2 bytes
  std::span<std::uint16_t> data_;
  std::uint32_t used_ = 0;  ///< of data_
  unsigned part_bits_ = 0;
  std::uint64_t section_pixels_ = 0;
};

template <class Visit>
void CrossingStore::for_each_row(const RowRoom& room, Visit visit) {
  std::uint8_t none = 0;
  for (std::uint32_t tile_row = 0; tile_row < tile_rows_; ++tile_row) {
    const auto directory = directory_.subspan(std::size_t{tile_row} * tile_columns_, tile_columns_);
    if (std::ranges::all_of(directory, [](std::uint32_t at) { return at == kEmpty; })) continue;
    for (std::uint32_t t = 0; t < tile_columns_; ++t) {
      // The end of data_ if the last tile has no crossings.
      room.reads[t] = room.writes[t] =
          directory[t] == kEmpty ? nullptr : data_.data() + directory[t] + kRaysPerTile / 2;
    }
    for (std::uint32_t r = 0; r < kTileSide && tile_row * kTileSide + r < grid_.rows; ++r) {
      for (std::uint32_t c = 0; c < grid_.columns; ++c) {
        const std::uint32_t t = c / kTileSide;
        RayRef& ray = room.rays[c];
        ray.count_ = &none;
        ray.read_ = room.reads[t];
        ray.write_ = &room.writes[t];
        ray.part_bits_ = part_bits_;
        if (directory[t] != kEmpty) {
          ray.count_ =
              reinterpret_cast<std::uint8_t*>(&data_[directory[t]]) + std::size_t{r} * kTileSide + c % kTileSide;
          room.reads[t] += *ray.count_;
        }
      }
      visit(tile_row * kTileSide + r, room.rays);
    }
  }
}

}  // namespace plumbline::inline slicer
