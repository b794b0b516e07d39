#include "slicer/rrep/components.hpp"

#include <algorithm>
#include <limits>

#include "slicer/core/disjoint_sets.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "components";
/// A solid may float, or a cavity be sealed, below 1 / kSmallShare of the largest solid's voxels. Larger values keep more
/// background, smaller ones lose detached parts of the object.
constexpr std::uint32_t kSmallShare = 500;
constexpr std::uint32_t kOutside = 0;  ///< number of the interval outside the object

/// A ray's crossings and the number of its first inner interval.
///
/// c crossings part the ray into intervals 0 to c; the odd ones are solid. Interval 0, and interval c if c is even, are
/// outside; the others are numbered in the order of the rays.
struct Ray {
  std::span<const std::uint16_t> crossings;
  std::uint32_t first = 0;

  std::uint32_t inner() const { return numbered(static_cast<std::uint32_t>(crossings.size())); }
  static std::uint32_t numbered(std::uint32_t count) { return count == 0 ? 0 : count - (count % 2 == 0 ? 1 : 0); }
  std::uint32_t number(std::uint32_t interval) const {
    return interval == 0 || interval > inner() ? kOutside : first + interval - 1;
  }
  std::uint32_t low(std::uint32_t interval) const { return interval == 0 ? 0 : crossings[interval - 1]; }
  std::uint32_t high(std::uint32_t interval, std::uint32_t layers) const {
    return interval < crossings.size() ? crossings[interval] : layers;
  }
};

class Intervals {
 public:
  Intervals(std::span<std::uint32_t> parent, std::span<std::uint32_t> volume) : sets_(parent), volume_(volume) {
    sets_.start_all();
    std::fill(volume_.begin(), volume_.end(), 0);
  }
  /// The lowest interval of the set; kOutside for the outside.
  std::uint32_t root(std::uint32_t i) const { return sets_.root(i); }
  void unite(std::uint32_t a, std::uint32_t b) { sets_.unite(a, b); }
  void grow(std::uint32_t i, std::uint64_t voxels) {
    const auto sum = std::min<std::uint64_t>(kMostVoxels, volume(i) + voxels);
    volume_[i] = (volume_[i] & ~kMostVoxels) | static_cast<std::uint32_t>(sum);
  }
  std::uint32_t volume(std::uint32_t i) const { return volume_[i] & kMostVoxels; }

  static constexpr std::uint32_t kMostVoxels = (1U << 30) - 1;
  static constexpr std::uint32_t kAtPlate = 1U << 30;     ///< some of the component begins on the plate
  static constexpr std::uint32_t kBelowPlate = 1U << 31;  ///< some of it begins below the plate
  void mark(std::uint32_t root, std::uint32_t where) { volume_[root] |= where; }
  /// Records, in place of a component's volume, whether it is removed or filled.
  void decide(std::uint32_t root, bool goes) { volume_[root] = goes ? 1 : 0; }
  bool goes(std::uint32_t i) { return root(i) != kOutside && volume_[root(i)] != 0; }
  bool stands(std::uint32_t root) const { return (volume_[root] & (kAtPlate | kBelowPlate)) == kAtPlate; }
  std::uint32_t size() const { return sets_.size(); }

 private:
  DisjointSets<> sets_;
  std::span<std::uint32_t> volume_;  ///< voxels (a root's: of the whole component) and marks
};

/// Joins intervals of two neighbouring rays that share a layer and are both solid or both hollow.
void join(const Ray& a, const Ray& b, std::uint32_t layers, Intervals& intervals) {
  std::uint32_t i = 0;
  std::uint32_t j = 0;
  while (i <= a.crossings.size() && j <= b.crossings.size()) {
    const std::uint32_t high_a = a.high(i, layers);
    const std::uint32_t high_b = b.high(j, layers);
    const bool share = std::max(a.low(i), b.low(j)) < std::min(high_a, high_b);
    if (share && i % 2 == j % 2) intervals.unite(a.number(i), b.number(j));
    if (high_a <= high_b) ++i;
    if (high_b <= high_a) ++j;
  }
}

/// Decides which components are removed or filled.
struct Sieve {
  Intervals& intervals;
  std::uint64_t min_voxels;       ///< voxels: smaller components are removed or filled
  std::uint64_t floating_voxels;  ///< voxels: a solid with fewer must stand on the plate, a cavity with fewer is filled
  std::uint32_t largest_solid;
  bool is_small(std::uint32_t root) const {
    return root != kOutside && root != largest_solid && intervals.volume(root) < min_voxels;
  }
  bool floats(std::uint32_t root, bool solid) const {
    return solid && root != largest_solid && !intervals.stands(root) && intervals.volume(root) < floating_voxels;
  }
  bool is_sealed(std::uint32_t root, bool solid) const {
    return !solid && root != kOutside && intervals.volume(root) < floating_voxels;
  }
  bool goes(std::uint32_t root, bool solid) const {
    return is_small(root) || floats(root, solid) || is_sealed(root, solid);
  }
};

/// Marks the solids that begin within `layers` of the plate, which is where the largest one begins.
void mark_plate(CrossingStore& store, const CrossingStore::RowRoom& room, std::uint32_t largest, std::uint32_t layers,
                Intervals& intervals) {
  const auto for_each_solid = [&](auto visit) {
    std::uint32_t first = 1;
    store.for_each_row(room, [&](std::uint32_t, std::span<CrossingStore::RayRef> row) {
      for (const auto& ref : row) {
        const Ray ray{ref.crossings(), first};
        first += ray.inner();
        for (std::uint32_t s = 1; s <= ray.inner(); s += 2) visit(intervals.root(ray.number(s)), ray.low(s));
      }
    });
  };
  std::uint32_t plate = std::numeric_limits<std::uint32_t>::max();
  for_each_solid([&](std::uint32_t root, std::uint32_t low) {
    if (root == largest) plate = std::min(plate, low);
  });
  for_each_solid([&](std::uint32_t root, std::uint32_t low) {
    if (low <= plate + layers)
      intervals.mark(root, low + layers < plate ? Intervals::kBelowPlate : Intervals::kAtPlate);
  });
}

}  // namespace

std::size_t components_bytes(const PrintGrid& grid, double rays, double crossings) {
  // A ray with c crossings has c - 1 inner intervals. Then rows of the visitor and of the search.
  constexpr std::size_t kMostStretches = std::numeric_limits<std::size_t>::max() / 64;  // in 32 bits, too
  constexpr auto kMost = static_cast<double>(kMostStretches);
  const auto intervals = static_cast<std::size_t>(std::clamp(crossings - rays, 0.0, kMost)) + 1;
  return 2 * sizeof(std::uint32_t) * intervals +
         grid.columns * (2 * sizeof(Ray) + sizeof(CrossingStore::RayRef) + 2 * sizeof(void*));
}

ComponentCounts drop_small_components(CrossingStore& store, const ComponentLimits& limits, Arena& arena) {
  const ArenaScope scope(arena);
  const PrintGrid& grid = store.grid();
  ComponentCounts counts;

  const auto room = store.take_row_room(arena);
  if (!room) return counts;
  std::size_t interval_count = 1;  // fewer than the crossings, which are in memory
  store.for_each_row(*room, [&](std::uint32_t, std::span<CrossingStore::RayRef> row) {
    for (const auto& ray : row) interval_count += Ray::numbered(ray.count());
  });
  auto parent = arena.take_top<std::uint32_t>(interval_count, kStage);
  auto volume = parent ? arena.take_top<std::uint32_t>(interval_count, kStage) : parent;
  auto rows = arena.take_top<Ray>(2 * std::size_t{grid.columns}, kStage);
  if (!parent || !volume || !rows) return counts;
  counts.counted = true;
  Intervals intervals(*parent, *volume);

  std::span<Ray> above = rows->first(grid.columns);
  std::span<Ray> here = rows->last(grid.columns);
  std::fill(above.begin(), above.end(), Ray{});
  std::uint32_t next = 1;
  store.for_each_row(*room, [&](std::uint32_t, std::span<CrossingStore::RayRef> row) {
    for (std::uint32_t c = 0; c < grid.columns; ++c) {
      here[c] = Ray{row[c].crossings(), next};
      next += here[c].inner();
      for (std::uint32_t s = 1; s <= here[c].inner(); ++s) {
        intervals.grow(here[c].number(s), here[c].high(s, grid.layers) - here[c].low(s));
      }
      join(above[c], here[c], grid.layers, intervals);
      if (c > 0) join(here[c - 1], here[c], grid.layers, intervals);
    }
    std::swap(above, here);
  });

  // Volumes go to the roots. A root's number is the lowest of its set, so every number above it is seen after it.
  for (std::uint32_t i = 1; i < intervals.size(); ++i) {
    const std::uint32_t root = intervals.root(i);
    if (root != i) intervals.grow(root, intervals.volume(i));
  }
  Sieve sieve{intervals, limits.min_voxels, 0, kOutside};
  const auto for_each_root = [&](auto visit) {
    std::uint32_t number = 1;
    store.for_each_row(*room, [&](std::uint32_t, std::span<CrossingStore::RayRef> row) {
      for (const auto& ray : row) {
        const std::uint32_t inner = Ray::numbered(ray.count());
        for (std::uint32_t s = 1; s <= inner; ++s, ++number) {
          // The interval below a component's root, in its first row, belongs to the component that encloses it.
          if (intervals.root(number) == number) visit(number, s % 2 == 1, s == 1 ? kOutside : number - 1);
        }
      }
    });
  };
  for_each_root([&](std::uint32_t root, bool solid, std::uint32_t) {
    const bool larger =
        sieve.largest_solid == kOutside || intervals.volume(root) > intervals.volume(sieve.largest_solid);
    if (solid && larger) sieve.largest_solid = root;
  });
  if (limits.drop_floating && sieve.largest_solid != kOutside) {
    sieve.floating_voxels = intervals.volume(sieve.largest_solid) / kSmallShare;
    mark_plate(store, *room, sieve.largest_solid, limits.plate_layers, intervals);
  }
  // Roots ascend, so an enclosing component is decided before those inside it.
  for_each_root([&](std::uint32_t root, bool solid, std::uint32_t encloser) {
    const std::uint32_t voxels = intervals.volume(root);
    const bool merges = intervals.goes(encloser);  // with the encloser, which then becomes the same kind
    const bool goes = !merges && sieve.goes(root, solid);
    if (goes) counts.changed_voxels += voxels;
    if (goes && !sieve.is_small(root)) ++(solid ? counts.floating_solids : counts.sealed_cavities);
    if (!goes && solid) counts.voxels += voxels;
    if (!merges)
      ++(solid ? (goes ? counts.dropped_solids : counts.solids) : (goes ? counts.filled_cavities : counts.cavities));
    intervals.decide(root, goes);
  });
  if (counts.dropped_solids + counts.filled_cavities == 0) return counts;

  std::uint32_t number = 1;
  store.for_each_row(*room, [&](std::uint32_t, std::span<CrossingStore::RayRef> row) {
    for (auto& ray : row) {
      const Ray old{ray.crossings(), number};
      const auto count = static_cast<std::uint32_t>(old.crossings.size());
      number += old.inner();
      // A crossing stays if the intervals on both sides of it still differ once components have changed.
      const auto solid = [&](std::uint32_t s) { return (s % 2 == 1) != intervals.goes(old.number(s)); };
      ray.begin_rewrite();
      for (std::uint32_t s = 0; s < count; ++s) {
        if (solid(s) != solid(s + 1)) ray.keep(old.crossings[s]);
      }
      ray.end_rewrite();
    }
  });
  return counts;
}

}  // namespace plumbline
