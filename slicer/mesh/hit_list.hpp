#pragma once
/// The hits of all rays, collected in the order of the triangles and sorted by ray.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/mesh/triangle_rays.hpp"

namespace plumbline {

/// A hit in one word, so that sorting words sorts by tile, ray in the tile, and layer:
///
///   bits 23 to 44  tile, row by row
///   bits 17 to 22  ray in the tile, row by row
///   bits  1 to 16  layer
///   bit   0        1: exiting
class PackedHit {
 public:
  PackedHit() = default;
  PackedHit(const RayHit& hit, std::uint32_t tile_columns) {
    const std::uint64_t tile = std::uint64_t{hit.row / kTileSide} * tile_columns + hit.column / kTileSide;
    const std::uint64_t ray = hit.row % kTileSide * kTileSide + hit.column % kTileSide;
    word_ = tile << 23U | ray << 17U | std::uint64_t{hit.layer} << 1U | (hit.entering ? 0U : 1U);
  }
  /// Less than any hit of the tile, and above those of the tiles before.
  static PackedHit before_tile(std::uint32_t tile) {
    PackedHit hit;
    hit.word_ = std::uint64_t{tile} << 23U;
    return hit;
  }

  std::uint32_t tile() const { return static_cast<std::uint32_t>(word_ >> 23U); }
  std::uint32_t ray() const { return static_cast<std::uint32_t>(word_ >> 17U) & 63U; }
  std::uint32_t layer() const { return static_cast<std::uint32_t>(word_ >> 1U) & 0xFFFFU; }
  int winding() const {
    return (word_ & 1U) != 0 ? -1 : 1;
  }  ///< what the hit adds to the winding number of the ray above it
  bool is_on_ray_of(const PackedHit& other) const { return word_ >> 17U == other.word_ >> 17U; }
  auto operator<=>(const PackedHit&) const = default;  // NOLINT(modernize-use-nullptr): compares with literal 0

 private:
  std::uint64_t word_ = 0;
};

/// The hits of one ray, in order.
struct RayHits {
  std::span<const PackedHit> all;
  bool drops_doubled = false;  ///< those that are equal to the one below are left out

  bool empty() const { return all.empty(); }
  std::size_t size() const { return all.size(); }
  bool keeps(std::size_t i) const { return !drops_doubled || i == 0 || all[i] != all[i - 1]; }
};

/// Takes the rest of the arena for hits, and gives back what they don't need.
class HitList {
 public:
  /// Call it last of all that takes room while triangles are read.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<HitList> create(const PrintGrid& grid, Arena& arena);

  /// @returns false if the list is full
  [[nodiscard]] bool add(const RayHit& hit) {
    if (free_ == 0) return false;
    hits_[--free_] = PackedHit(hit, tile_columns_);
    return true;
  }
  std::size_t size() const { return hits_.size() - free_; }
  std::size_t capacity() const { return hits_.size(); }
  std::uint32_t tile_columns() const { return tile_columns_; }
  std::uint32_t tile_rows() const { return tile_rows_; }

  /// Gives the unused memory back, and sorts.
  /// @param arena  with nothing at its top that was taken after the list
  [[nodiscard]] Status close(Arena& arena);

  /// After close(): can be added to again, until the next close().
  /// @param arena  as for close(). The list takes the rest of it
  [[nodiscard]] Status reopen(Arena& arena);

  /// After close(): from now on, hits that are there twice on a ray are left out if the others come nearer to entering as often as
  /// exiting. So a face that is there twice does no harm.
  /// @returns whether there are any
  bool drop_doubled();

  /// After close(): the hits in order.
  std::span<const PackedHit> all() const { return hits_.subspan(free_); }
  std::span<const PackedHit> of_tile(std::uint32_t tile) const;
  RayHits of_ray(std::uint32_t column, std::uint32_t row) const;
  /// The hits of ray `ray` at the front of those of its tile, from which it removes them.
  RayHits take_ray(std::span<const PackedHit>& in_tile, std::uint32_t ray) const;

 private:
  std::span<PackedHit> hits_;  ///< filled from the back, so that nothing moves when the front is given back
  std::size_t free_ = 0;
  std::size_t top_ = 0;  ///< mark of the arena before the list
  std::uint32_t tile_columns_ = 0;
  std::uint32_t tile_rows_ = 0;
  bool drops_doubled_ = false;
};

/// Sorts hits in place: into buckets by their tile, then each bucket.
/// @param tiles  all hits lie in tiles below it
void sort_hits(std::span<PackedHit> hits, std::uint32_t tiles);

}  // namespace plumbline
