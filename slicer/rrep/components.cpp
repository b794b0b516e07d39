#include "slicer/rrep/components.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "slicer/core/disjoint_sets.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "components";
/// A solid may float, or a cavity be sealed, below 1 / kSmallShare of the largest solid's voxels. Larger values keep more
/// background, smaller ones lose detached parts of the object.
constexpr std::uint32_t kSmallShare = 500;
/// Parts of a sparse scan's object, such as the links of a chain, may be below min_voxels. What has more than 1 / kPartShare of the largest
/// solid's voxels is no speck beside it, unless it has less than a kOutlierShare of min_voxels, twice what a single outlier makes.
constexpr std::uint32_t kPartShare = 20;
constexpr std::uint32_t kOutlierShare = 4;
constexpr std::uint32_t kOutside = 0;  ///< number of the interval outside the object

/// A ray's crossings and the number of its first inner interval.
///
/// c crossings part the ray into intervals 0 to c; the odd ones are solid. Interval 0, and interval c if c is even, are
/// outside; the others are numbered in the order of the rays.
struct Ray {
  StoredHeights crossings;
  std::uint32_t first = 0;

  /// Inner intervals.
  std::uint32_t inner() const {
    const auto count = static_cast<std::uint32_t>(crossings.size());
    return count == 0 ? 0 : count - (count % 2 == 0 ? 1 : 0);
  }
  std::uint32_t number(std::uint32_t interval) const {
    return interval == 0 || interval > inner() ? kOutside : first + interval - 1;
  }
  std::uint32_t low(std::uint32_t interval) const { return interval == 0 ? 0 : crossings.layer(interval - 1); }
  std::uint32_t high(std::uint32_t interval, std::uint32_t layers) const {
    return interval < crossings.size() ? crossings.layer(interval) : layers;
  }
};

/// A component: a set of intervals that are joined. The one of kOutside is the outside.
struct Component {
  std::uint64_t voxels = 0;
  std::uint32_t encloser = kOutside;  ///< number of the component around it
  std::uint16_t low = 0;              ///< the layer that it begins at
  bool solid = false;
  bool goes = false;  ///< it is removed or filled
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

/// Calls visit(ref, ray) for each ray, in the order of the intervals' numbers.
template <class Visit>
void for_each_ray(CrossingStore& store, const CrossingStore::RowRoom& room, Visit visit) {
  std::uint32_t next = 1;
  store.for_each_row(room, [&](std::uint32_t, std::span<CrossingStore::RayRef> row) {
    for (auto& ref : row) {
      const Ray ray{ref.crossings(), next};
      next += ray.inner();
      visit(ref, ray);
    }
  });
}

}  // namespace

std::size_t components_bytes(const PrintGrid& grid, double rays, double crossings) {
  // A ray with c crossings has c - 1 inner intervals. Then rows of the visitor and of the search.
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max() / 64;  // in 32 bits, too
  const auto intervals = static_cast<std::size_t>(std::clamp(crossings - rays, 0.0, static_cast<double>(kMost))) + 1;
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
  for_each_ray(store, *room, [&](const auto&, const Ray& ray) { interval_count += ray.inner(); });
  auto parent = arena.take_top<std::uint32_t>(interval_count, kStage);
  auto rows = arena.take_top<Ray>(2 * std::size_t{grid.columns}, kStage);
  if (!parent || !rows) return counts;
  DisjointSets<> intervals(*parent);
  intervals.start_all();

  std::span<Ray> above = rows->first(grid.columns);
  std::span<Ray> here = rows->last(grid.columns);
  std::uint32_t next = 1;
  std::uint32_t row_above = grid.rows;  // none
  store.for_each_row(*room, [&](std::uint32_t r, std::span<CrossingStore::RayRef> row) {
    if (r != std::exchange(row_above, r) + 1) std::fill(above.begin(), above.end(), Ray{});
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
  std::fill(components->begin(), components->end(), Component{});
  const auto component_of = [&](const Ray& ray, std::uint32_t s) -> Component& {
    return (*components)[(*parent)[ray.number(s)]];
  };
  for_each_ray(store, *room, [&](const auto&, const Ray& ray) {
    for (std::uint32_t s = 1; s <= ray.inner(); ++s) {
      Component& c = component_of(ray, s);
      const auto low = static_cast<std::uint16_t>(ray.low(s));
      // The interval below a component's first one belongs to the component around it.
      if (c.voxels == 0) c = {0, (*parent)[ray.number(s - 1)], low, s % 2 == 1};
      c.voxels += ray.high(s, grid.layers) - low;
      c.low = std::min(c.low, low);
    }
  });
  const auto inner = components->subspan(1);
  const Component* largest = nullptr;  // solid
  for (const Component& c : inner) {
    if (c.solid && (largest == nullptr || c.voxels > largest->voxels)) largest = &c;
  }
  const std::uint64_t floating_voxels =
      limits.drop_floating && largest != nullptr ? largest->voxels / kSmallShare : std::uint64_t{0};
  const std::uint64_t part_voxels = largest != nullptr ? largest->voxels / kPartShare : std::uint64_t{0};
  const std::uint64_t small_voxels =
      std::min(limits.min_voxels, std::max(limits.min_voxels / kOutlierShare, part_voxels));
  const auto is_small = [&](const Component& c) { return &c != largest && c.voxels < small_voxels; };
  const auto stands = [&](const Component& c) {
    return c.solid && c.low <= largest->low + limits.plate_layers && largest->low <= c.low + limits.plate_layers;
  };
  // Numbers ascend, so an enclosing component is decided before those inside it.
  for (Component& c : inner) {
    const bool merges = (*components)[c.encloser].goes;  // with the encloser, which then becomes the same kind
    c.goes = !merges && (is_small(c) || (c.voxels < floating_voxels && !stands(c)));
    if (c.goes) counts.changed_voxels += c.voxels;
    if (c.goes && c.solid) counts.dropped_voxels += c.voxels;
    if (c.goes && !is_small(c)) ++(c.solid ? counts.floating_solids : counts.sealed_cavities);
    if (!c.goes && c.solid) counts.voxels += c.voxels;
    if (merges) continue;
    if (c.goes) ++(c.solid ? counts.dropped_solids : counts.filled_cavities);
    if (!c.goes) ++(c.solid ? counts.solids : counts.cavities);
  }
  if (counts.dropped_solids + counts.filled_cavities == 0) return counts;

  for_each_ray(store, *room, [&](CrossingStore::RayRef& ref, const Ray& ray) {
    // A crossing stays if the intervals on both sides of it still differ once components have changed.
    const auto solid = [&](std::uint32_t s) { return (s % 2 == 1) != component_of(ray, s).goes; };
    ref.rewrite([&](std::uint32_t s) { return solid(s) != solid(s + 1); });
  });
  return counts;
}

}  // namespace plumbline::inline slicer
