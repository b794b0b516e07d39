#pragma once
/// The hits of all rays, collected in the order of the triangles and sorted by ray.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/mesh/triangle_rays.hpp"

namespace plumbline::inline slicer {

/// A hit in one word, so that sorting words sorts by tile, ray in the tile, and layer:
///
///   bits 42 to 63  tile, row by row
///   bits 36 to 41  ray in the tile, row by row
///   bits 20 to 35  layer
///   bit  19        1: exiting
///   bits  0 to 18  body
class PackedHit {
 public:
  static constexpr std::uint32_t kMostBodies = 1U << 19U;

  PackedHit() = default;
  /// @param body  of the triangle, below kMostBodies
  PackedHit(const RayHit& hit, std::uint32_t tile_columns, std::uint32_t body = 0) {
    const std::uint64_t tile = std::uint64_t{hit.row / kTileSide} * tile_columns + hit.column / kTileSide;
    const std::uint64_t ray = hit.row % kTileSide * kTileSide + hit.column % kTileSide;
    word_ = tile << kTileBit | ray << kRayBit | std::uint64_t{hit.layer} << kLayerBit |
            std::uint64_t{hit.entering ? 0U : 1U} << kExitBit | body;
  }
  /// Less than any hit of the tile, and above those of the tiles before.
  static PackedHit before_tile(std::uint32_t tile) {
    PackedHit hit;
    hit.word_ = std::uint64_t{tile} << kTileBit;
    return hit;
  }

  std::uint32_t tile() const { return static_cast<std::uint32_t>(word_ >> kTileBit); }
  std::uint32_t ray() const { return static_cast<std::uint32_t>(word_ >> kRayBit) & 63U; }
  std::uint32_t layer() const { return static_cast<std::uint32_t>(word_ >> kLayerBit) & 0xFFFFU; }
  /// What the hit adds to the winding number of the ray above it.
  int winding() const { return (word_ >> kExitBit & 1U) != 0 ? -1 : 1; }
  std::uint32_t body() const { return static_cast<std::uint32_t>(word_) & (kMostBodies - 1); }
  bool is_on_ray_of(const PackedHit& other) const { return word_ >> kRayBit == other.word_ >> kRayBit; }
  /// Whether it differs in its body at most.
  bool is_again(const PackedHit& other) const { return word_ >> kExitBit == other.word_ >> kExitBit; }
  /// The same hit of another body, turned over if asked for.
  PackedHit of_body(std::uint32_t body, bool turned) const {
    PackedHit hit;
    hit.word_ = ((word_ >> kExitBit ^ (turned ? 1U : 0U)) << kExitBit) | body;
    return hit;
  }
  auto operator<=>(const PackedHit&) const = default;  // NOLINT(modernize-use-nullptr): compares with literal 0

 private:
  static constexpr unsigned kExitBit = 19;
  static constexpr unsigned kLayerBit = 20;
  static constexpr unsigned kRayBit = 36;
  static constexpr unsigned kTileBit = 42;

  std::uint64_t word_ = 0;
};

/// The hits of one ray, in order.
struct RayHits {
  std::span<const PackedHit> all;
  bool drops_doubled = false;  ///< those that are equal to the one below are left out

  bool empty() const { return all.empty(); }
  std::size_t size() const { return all.size(); }
  bool keeps(std::size_t i) const { return !drops_doubled || i == 0 || !all[i].is_again(all[i - 1]); }
};

/// Sorts hits in place: into buckets by their tile, then each bucket.
/// @param tiles  all hits lie in tiles below it
void sort_hits(std::span<PackedHit> hits, std::uint32_t tiles);

/// Takes the rest of the arena for hits, and gives back what they don't need.
class HitList {
 public:
  /// Call it last of all that takes room while triangles are read.
  /// @retval ErrorCode::kOutOfMemory
  /// @param of_shells  the bodies of the hits are numbers of shells, not BodyLabels, until change_all()
  [[nodiscard]] static Expected<HitList> create(const PrintGrid& grid, Arena& arena, bool of_shells = false);

  /// @returns false if the list is full
  [[nodiscard]] bool add(const RayHit& hit, std::uint32_t body = 0) {
    if (free_ == 0) return false;
    hits_[--free_] = PackedHit(hit, tile_columns_, body);
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

  /// After close(): replaces each hit by change(hit), which is on the same ray and has a BodyLabel, and sorts.
  template <class Change>
  void change_all(Change change) {
    for (PackedHit& hit : hits_) hit = change(hit);
    of_shells_ = false;
    sort();
  }

  /// Gives all of its memory back.
  void release(Arena& arena) const { arena.release_top(top_); }

  /// After close(): from now on, hits that are there twice on a ray are left out if the others come nearer to entering as often as
  /// exiting. So a face that is there twice does no harm.
  /// @returns whether there are any
  bool drop_doubled();

  /// After close(): the hits in order, but for those of negative volumes.
  std::span<const PackedHit> all() const { return hits_.first(hits_.size() - negative_); }
  /// Calls visit(hits) for each ray that has some, with those of all().
  template <class Visit>
  void for_each_ray(Visit visit) const {
    const auto hits = all();
    for (std::size_t begin = 0, end = 0; begin < hits.size(); begin = end) {
      while (end < hits.size() && hits[end].is_on_ray_of(hits[begin])) ++end;
      visit(hits.subspan(begin, end - begin));
    }
  }
  std::span<const PackedHit> of_tile(std::uint32_t tile) const { return of_tile(all(), tile); }
  /// Those of negative volumes.
  std::span<const PackedHit> negative_of_tile(std::uint32_t tile) const { return of_tile(hits_.last(negative_), tile); }
  RayHits of_ray(std::uint32_t column, std::uint32_t row) const;
  /// The hits of ray `ray` at the front of those of its tile, from which it removes them.
  RayHits take_ray(std::span<const PackedHit>& in_tile, std::uint32_t ray) const;

 private:
  static std::span<const PackedHit> of_tile(std::span<const PackedHit> hits, std::uint32_t tile);
  void sort();

  std::span<PackedHit> hits_;  ///< filled from the back, so that nothing moves when the front is given back
  std::size_t free_ = 0;
  std::size_t negative_ = 0;  ///< at the back
  std::size_t top_ = 0;       ///< mark of the arena before the list
  std::uint32_t tile_columns_ = 0;
  std::uint32_t tile_rows_ = 0;
  bool of_shells_ = false;
  bool drops_doubled_ = false;
};

}  // namespace plumbline::inline slicer
