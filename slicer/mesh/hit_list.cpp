#include "slicer/mesh/hit_list.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>

#include "slicer/reader/triangles/triangle.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "mesh";
/// Buckets of the first step: so many that a bucket of a large mesh fits a cache of 256 KiB, so few that their ends do, too.
constexpr std::uint32_t kBuckets = 1024;

/// Whether the hits of a ray come nearer to entering as often as exiting if none is there twice.
bool balances_without_doubled(std::span<const PackedHit> all, const HitPacking& packing) {
  const RayHits ray{all, packing, true};
  int sum = 0;
  int sum_of_different = 0;
  for (std::size_t i = 0; i < ray.size(); ++i) {
    sum += ray.winding(i);
    if (ray.keeps(i)) sum_of_different += ray.winding(i);
  }
  return std::abs(sum_of_different) < std::abs(sum);
}

}  // namespace

Expected<HitList> HitList::create(const PrintGrid& grid, Arena& arena, bool of_shells) {
  HitList list;
  list.of_shells_ = of_shells;
  list.packing_ = HitPacking(grid);
  list.top_ = arena.top_mark();
  list.tile_columns_ = (grid.columns + kTileSide - 1) / kTileSide;
  list.tile_rows_ = (grid.rows + kTileSide - 1) / kTileSide;
  PLUMBLINE_TRY(list.reopen(arena));
  return list;
}

Status HitList::reopen(Arena& arena) {
  const auto kept = hits_.subspan(free_);
  arena.release_top(top_);
  constexpr std::size_t kInBlock = Arena::kAlignment / sizeof(PackedHit);
  const auto hits = arena.take_top<PackedHit>(arena.available() / sizeof(PackedHit) / kInBlock * kInBlock, kStage);
  PLUMBLINE_TRY(hits);
  std::copy_backward(kept.begin(), kept.end(), hits->end());  // to the same place, or less than a cache line up
  hits_ = *hits;
  free_ = hits->size() - kept.size();
  return {};
}

Status HitList::close(Arena& arena) {
  const auto kept = hits_.subspan(free_);
  arena.release_top(top_);
  const auto hits = arena.take_top<PackedHit>(kept.size(), kStage);
  PLUMBLINE_TRY(hits);
  std::copy(kept.begin(), kept.end(), hits->begin());  // to the same place, or less than a cache line down
  hits_ = *hits;
  free_ = 0;
  sort();
  return {};
}

void HitList::sort() {
  const auto is_solid = [](const PackedHit& hit) { return !BodyLabel::of(hit.body()).is_negative(); };
  const auto negative = of_shells_ ? hits_.end() : std::partition(hits_.begin(), hits_.end(), is_solid);
  negative_ = static_cast<std::size_t>(hits_.end() - negative);
  sort_hits(hits_.first(hits_.size() - negative_), packing_, tile_columns_ * tile_rows_);
  sort_hits(hits_.last(negative_), packing_, tile_columns_ * tile_rows_);
}

bool HitList::drop_doubled() {
  for_each_ray([&](std::span<const PackedHit> ray) {
    drops_doubled_ = drops_doubled_ || balances_without_doubled(ray, packing_);
  });
  return drops_doubled_;
}

RayHits HitList::take_ray(std::span<const PackedHit>& in_tile, std::uint32_t ray) const {
  std::size_t count = 0;
  while (count < in_tile.size() && packing_.ray(in_tile[count]) == ray) ++count;
  const auto taken = in_tile.first(count);
  in_tile = in_tile.subspan(count);
  return {taken, packing_, drops_doubled_ && balances_without_doubled(taken, packing_)};
}

std::span<const PackedHit> HitList::of_tile(std::span<const PackedHit> hits, std::uint32_t tile) const {
  const auto begin = std::lower_bound(hits.begin(), hits.end(), packing_.before_tile(tile));
  const auto end = std::lower_bound(begin, hits.end(), packing_.before_tile(tile + 1));
  return {begin, end};
}

RayHits HitList::of_ray(std::uint32_t column, std::uint32_t row) const {
  const std::uint32_t number = row % kTileSide * kTileSide + column % kTileSide;
  auto in_tile = of_tile(row / kTileSide * tile_columns_ + column / kTileSide);
  while (!in_tile.empty() && packing_.ray(in_tile.front()) < number) in_tile = in_tile.subspan(1);
  return take_ray(in_tile, number);
}

void sort_hits(std::span<PackedHit> hits, const HitPacking& packing, std::uint32_t tiles) {
  // American flag sort (McIlroy, Bostic, McIlroy 1993): each hit is swapped to where its bucket ends so far.
  const auto shift = static_cast<std::uint32_t>(std::bit_width(std::max(tiles, kBuckets) / kBuckets) - 1) + 1;
  const auto bucket_of = [&](const PackedHit& hit) { return packing.tile(hit) >> shift; };
  std::array<std::size_t, kBuckets + 1> first{};
  for (const PackedHit& hit : hits) ++first[bucket_of(hit) + std::size_t{1}];
  for (std::size_t b = 1; b < first.size(); ++b) first[b] += first[b - 1];
  std::array<std::size_t, kBuckets> next{};
  std::copy_n(first.begin(), kBuckets, next.begin());
  for (std::uint32_t b = 0; b < kBuckets; ++b) {
    while (next[b] < first[b + std::size_t{1}]) {
      PackedHit& here = hits[next[b]];
      const std::uint32_t home = bucket_of(here);
      if (home == b) {
        ++next[b];
      } else {
        std::swap(here, hits[next[home]++]);
      }
    }
  }
#pragma omp parallel for schedule(dynamic, 8)
  for (std::uint32_t b = 0; b < kBuckets; ++b) {
    std::sort(hits.begin() + static_cast<std::ptrdiff_t>(first[b]),
              hits.begin() + static_cast<std::ptrdiff_t>(first[b + std::size_t{1}]));
  }
}

}  // namespace plumbline::inline slicer
