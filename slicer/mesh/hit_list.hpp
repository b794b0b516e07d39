#pragma once
/// The hits of all rays, collected in the order of the triangles and sorted by ray.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/mesh/triangle_rays.hpp"

namespace plumbline::inline slicer {

/// A hit in one word: see HitPacking.
class PackedHit {
 public:
  static constexpr unsigned kBodyBits = 19;
  static constexpr std::uint32_t kMostBodies = 1U << kBodyBits;

  PackedHit() = default;
  std::uint32_t body() const { return static_cast<std::uint32_t>(word_) % kMostBodies; }
  auto operator<=>(const PackedHit&) const = default;  // NOLINT(modernize-use-nullptr): compares with literal 0

 private:
  friend class HitPacking;
  explicit PackedHit(std::uint64_t word) : word_(word) {}

  std::uint64_t word_ = 0;
};

/// Packs hits so that sorting words sorts by tile, ray in the tile, and layer. From the top: tile, row by row; ray in the tile, row by row;
/// layer; one bit that is 1 if it exits; as much of the height within the layer as there is room for; body.
class HitPacking {
 public:
  HitPacking() = default;
  explicit HitPacking(const PrintGrid& grid) : tile_columns_((grid.columns + kTileSide - 1) / kTileSide) {
    const std::uint32_t tiles = tile_columns_ * ((grid.rows + kTileSide - 1) / kTileSide);
    const auto layer_bits = static_cast<unsigned>(std::bit_width(grid.layers));
    const auto tile_bits = static_cast<unsigned>(std::bit_width(tiles));
    const unsigned others = PackedHit::kBodyBits + 1 + layer_bits + kRayBits + tile_bits;
    part_bits_ = std::min(CrossingHeight::kBits, 64 - std::min(64U, others));
    exit_bit_ = PackedHit::kBodyBits + part_bits_;
    ray_bit_ = exit_bit_ + 1 + layer_bits;
  }

  /// @param body  of the triangle, below PackedHit::kMostBodies
  PackedHit packed(const RayHit& hit, std::uint32_t body = 0) const {
    const std::uint64_t tile = std::uint64_t{hit.row / kTileSide} * tile_columns_ + hit.column / kTileSide;
    const std::uint64_t ray = hit.row % kTileSide * kTileSide + hit.column % kTileSide;
    return PackedHit((tile << kRayBits | ray) << ray_bit_ |
                     (std::uint64_t{hit.height.layer()} << 1U | (hit.entering ? 0U : 1U)) << exit_bit_ |
                     std::uint64_t{hit.height.part(part_bits_)} << PackedHit::kBodyBits | body);
  }
  /// Less than any hit of the tile, and above those of the tiles before.
  PackedHit before_tile(std::uint32_t tile) const { return PackedHit(std::uint64_t{tile} << kRayBits << ray_bit_); }
  /// The same hit of another body, turned over if asked for.
  PackedHit of_body(const PackedHit& hit, std::uint32_t body, bool turned) const {
    const std::uint64_t turn = turned ? std::uint64_t{1} << exit_bit_ : 0;
    return PackedHit(((hit.word_ ^ turn) >> PackedHit::kBodyBits) << PackedHit::kBodyBits | body);
  }

  std::uint32_t tile(const PackedHit& hit) const {
    return static_cast<std::uint32_t>(hit.word_ >> ray_bit_ >> kRayBits);
  }
  std::uint32_t ray(const PackedHit& hit) const {
    return static_cast<std::uint32_t>(hit.word_ >> ray_bit_) % kRaysPerTile;
  }
  std::uint32_t layer(const PackedHit& hit) const {
    const auto of_ray = hit.word_ & ((std::uint64_t{1} << ray_bit_) - 1);
    return static_cast<std::uint32_t>(of_ray >> (exit_bit_ + 1));
  }
  CrossingHeight height(const PackedHit& hit) const {
    const auto part = static_cast<std::uint32_t>(hit.word_ >> PackedHit::kBodyBits) % (1U << part_bits_);
    return CrossingHeight(layer(hit), CrossingHeight::part_of(part, part_bits_));
  }
  bool exits(const PackedHit& hit) const { return (hit.word_ >> exit_bit_ & 1U) != 0; }
  /// What the hit adds to the winding number of the ray above it.
  int winding(const PackedHit& hit) const { return exits(hit) ? -1 : 1; }
  bool are_on_one_ray(const PackedHit& a, const PackedHit& b) const {
    return a.word_ >> ray_bit_ == b.word_ >> ray_bit_;
  }
  /// Whether they are of one ray and layer and both enter or both exit.
  bool are_alike(const PackedHit& a, const PackedHit& b) const { return a.word_ >> exit_bit_ == b.word_ >> exit_bit_; }

 private:
  static constexpr unsigned kRayBits = 6;
  static_assert(kRaysPerTile == 1U << kRayBits);

  std::uint32_t tile_columns_ = 0;
  unsigned part_bits_ = 0;
  unsigned exit_bit_ = 0, ray_bit_ = 0;  ///< where they begin
};

/// The hits of one ray, in order.
struct RayHits {
  std::span<const PackedHit> all;
  HitPacking packing;
  bool drops_doubled = false;  ///< those that are alike the one below are left out

  bool empty() const { return all.empty(); }
  std::size_t size() const { return all.size(); }
  std::uint32_t layer(std::size_t i) const { return packing.layer(all[i]); }
  int winding(std::size_t i) const { return packing.winding(all[i]); }
  bool keeps(std::size_t i) const { return !drops_doubled || i == 0 || !packing.are_alike(all[i], all[i - 1]); }
};

/// Sorts hits in place: into buckets by their tile, then each bucket.
/// @param tiles  all hits lie in tiles below it
void sort_hits(std::span<PackedHit> hits, const HitPacking& packing, std::uint32_t tiles);

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
    hits_[--free_] = packing_.packed(hit, body);
    return true;
  }
  std::size_t size() const { return hits_.size() - free_; }
  std::size_t capacity() const { return hits_.size(); }
  std::uint32_t tile_columns() const { return tile_columns_; }
  std::uint32_t tile_rows() const { return tile_rows_; }
  const HitPacking& packing() const { return packing_; }

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
      while (end < hits.size() && packing_.are_on_one_ray(hits[end], hits[begin])) ++end;
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
  std::span<const PackedHit> of_tile(std::span<const PackedHit> hits, std::uint32_t tile) const;
  void sort();

  std::span<PackedHit> hits_;  ///< filled from the back, so that nothing moves when the front is given back
  std::size_t free_ = 0;
  std::size_t negative_ = 0;  ///< at the back
  std::size_t top_ = 0;       ///< mark of the arena before the list
  HitPacking packing_;
  std::uint32_t tile_columns_ = 0;
  std::uint32_t tile_rows_ = 0;
  bool of_shells_ = false;
  bool drops_doubled_ = false;
};

}  // namespace plumbline::inline slicer
