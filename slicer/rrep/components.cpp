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

/// A component: a set of intervals that are joined. The one of kOutside is the outside.
struct Component {
  std::uint64_t voxels : 61;
  std::uint64_t at_plate : 1;     ///< some of it begins on the plate
  std::uint64_t below_plate : 1;  ///< some of it begins below the plate
  std::uint64_t goes : 1;         ///< it is removed or filled
  bool stands() const { return at_plate != 0 && below_plate == 0; }
};

/// Room for components when memory is planned: one for so many intervals. Scans have one for thousands, pure noise one for a few.
constexpr std::size_t kIntervalsPerComponent = 64;

/// Joins intervals of two neighbouring rays that share a layer and are both solid or both hollow.
void join(const Ray& a, const Ray& b, std::uint32_t layers, DisjointSets<>& intervals) {
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

/// Numbers the components by their lowest intervals and gives each interval its component's number.
/// @returns how many there are, the outside included
std::uint32_t number_components(std::span<std::uint32_t> parent) {
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < parent.size(); ++i) {
    // A parent is a lower interval, so it has its component's number already.
    parent[i] = parent[i] == i ? count++ : parent[parent[i]];
  }
  return count;
}

/// The inner intervals of all rays, with the components that they belong to.
class Search {
 public:
  Search(CrossingStore& store, const CrossingStore::RowRoom& room, std::span<const std::uint32_t> component,
         std::span<Component> components)
      : store_(store), room_(room), component_(component), components_(components) {
    std::fill(components_.begin(), components_.end(), Component{});
  }

  std::uint32_t of(std::uint32_t interval) const { return component_[interval]; }
  Component& operator[](std::uint32_t component) const { return components_[component]; }

  /// Calls visit(ray, s) for each inner interval s of each ray.
  template <class Visit>
  void for_each(Visit visit) const {
    std::uint32_t first = 1;
    store_.for_each_row(room_, [&](std::uint32_t, std::span<CrossingStore::RayRef> row) {
      for (const auto& ref : row) {
        const Ray ray{ref.crossings(), first};
        first += ray.inner();
        for (std::uint32_t s = 1; s <= ray.inner(); ++s) visit(ray, s);
      }
    });
  }
  /// Calls visit(component, solid, encloser) for each component, in order of their numbers.
  template <class Visit>
  void for_each_component(Visit visit) const {
    std::uint32_t next = kOutside + 1;
    for_each([&](const Ray& ray, std::uint32_t s) {
      const std::uint32_t component = of(ray.number(s));
      if (component != next) return;
      // The interval below a component's first one belongs to the component that encloses it.
      visit(component, s % 2 == 1, of(ray.number(s - 1)));
      ++next;
    });
  }

 private:
  CrossingStore& store_;
  const CrossingStore::RowRoom& room_;
  std::span<const std::uint32_t> component_;  ///< by interval
  std::span<Component> components_;
};

/// Decides which components are removed or filled.
struct Sieve {
  const Search& search;
  std::uint64_t min_voxels;  ///< voxels: smaller components are removed or filled
  std::uint64_t floating_voxels =
      0;  ///< voxels: a solid with fewer must stand on the plate, a cavity with fewer is filled
  std::uint32_t largest_solid = kOutside;
  bool is_small(std::uint32_t c) const { return c != largest_solid && search[c].voxels < min_voxels; }
  bool floats(std::uint32_t c, bool solid) const {
    return solid && c != largest_solid && !search[c].stands() && search[c].voxels < floating_voxels;
  }
  bool is_sealed(std::uint32_t c, bool solid) const { return !solid && search[c].voxels < floating_voxels; }
  bool goes(std::uint32_t c, bool solid) const { return is_small(c) || floats(c, solid) || is_sealed(c, solid); }
};

/// Marks the solids that begin within `layers` of the plate, which is where the largest one begins.
void mark_plate(const Search& search, std::uint32_t largest, std::uint32_t layers) {
  std::uint32_t plate = std::numeric_limits<std::uint32_t>::max();
  search.for_each([&](const Ray& ray, std::uint32_t s) {
    if (search.of(ray.number(s)) == largest) plate = std::min(plate, ray.low(s));
  });
  search.for_each([&](const Ray& ray, std::uint32_t s) {
    const std::uint32_t low = ray.low(s);
    if (s % 2 == 0 || low > plate + layers) return;
    Component& component = search[search.of(ray.number(s))];
    if (low + layers < plate) {  // clang 14 can't assign to one of two bit-fields by ?:
      component.below_plate = 1;
    } else {
      component.at_plate = 1;
    }
  });
}

}  // namespace

std::size_t components_bytes(const PrintGrid& grid, double rays, double crossings) {
  // A ray with c crossings has c - 1 inner intervals. Then rows of the visitor and of the search.
  constexpr std::size_t kMostStretches = std::numeric_limits<std::size_t>::max() / 64;  // in 32 bits, too
  constexpr auto kMost = static_cast<double>(kMostStretches);
  const auto intervals = static_cast<std::size_t>(std::clamp(crossings - rays, 0.0, kMost)) + 1;
  return sizeof(std::uint32_t) * intervals + sizeof(Component) * (intervals / kIntervalsPerComponent + 2) +
         grid.columns * 2 * sizeof(Ray) + CrossingStore::row_room_bytes(grid);
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
  auto rows = arena.take_top<Ray>(2 * std::size_t{grid.columns}, kStage);
  if (!parent || !rows) return counts;
  DisjointSets<> intervals(*parent);
  intervals.start_all();

  std::span<Ray> above = rows->first(grid.columns);
  std::span<Ray> here = rows->last(grid.columns);
  std::fill(above.begin(), above.end(), Ray{});
  std::uint32_t next = 1;
  store.for_each_row(*room, [&](std::uint32_t, std::span<CrossingStore::RayRef> row) {
    for (std::uint32_t c = 0; c < grid.columns; ++c) {
      here[c] = Ray{row[c].crossings(), next};
      next += here[c].inner();
      join(above[c], here[c], grid.layers, intervals);
      if (c > 0) join(here[c - 1], here[c], grid.layers, intervals);
    }
    std::swap(above, here);
  });

  const auto components = arena.take_top<Component>(number_components(*parent), kStage);
  if (!components) return counts;
  counts.counted = true;
  const Search search(store, *room, *parent, *components);
  search.for_each([&](const Ray& ray, std::uint32_t s) {
    search[search.of(ray.number(s))].voxels += ray.high(s, grid.layers) - ray.low(s);
  });
  Sieve sieve{search, limits.min_voxels};
  search.for_each_component([&](std::uint32_t c, bool solid, std::uint32_t) {
    const bool larger = sieve.largest_solid == kOutside || search[c].voxels > search[sieve.largest_solid].voxels;
    if (solid && larger) sieve.largest_solid = c;
  });
  if (limits.drop_floating && sieve.largest_solid != kOutside) {
    sieve.floating_voxels = search[sieve.largest_solid].voxels / kSmallShare;
    mark_plate(search, sieve.largest_solid, limits.plate_layers);
  }
  // Numbers ascend, so an enclosing component is decided before those inside it.
  search.for_each_component([&](std::uint32_t c, bool solid, std::uint32_t encloser) {
    const std::uint64_t voxels = search[c].voxels;
    const bool merges = search[encloser].goes != 0;  // with the encloser, which then becomes the same kind
    const bool goes = !merges && sieve.goes(c, solid);
    if (goes) counts.changed_voxels += voxels;
    if (goes && solid) counts.dropped_voxels += voxels;
    if (goes && !sieve.is_small(c)) ++(solid ? counts.floating_solids : counts.sealed_cavities);
    if (!goes && solid) counts.voxels += voxels;
    if (!merges)
      ++(solid ? (goes ? counts.dropped_solids : counts.solids) : (goes ? counts.filled_cavities : counts.cavities));
    search[c].goes = goes ? 1 : 0;
  });
  if (counts.dropped_solids + counts.filled_cavities == 0) return counts;

  std::uint32_t number = 1;
  store.for_each_row(*room, [&](std::uint32_t, std::span<CrossingStore::RayRef> row) {
    for (auto& ray : row) {
      const Ray old{ray.crossings(), number};
      const auto count = static_cast<std::uint32_t>(old.crossings.size());
      number += old.inner();
      // A crossing stays if the intervals on both sides of it still differ once components have changed.
      const auto solid = [&](std::uint32_t s) { return (s % 2 == 1) != (search[search.of(old.number(s))].goes != 0); };
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
