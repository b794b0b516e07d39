#pragma once
/// The nearest points of a place, from all within a radius.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "slicer/cloud/kd_tree.hpp"

namespace plumbline::inline slicer {

/// Room for nearest_by_radius(), for up to half as many points.
using NearestRoom = std::array<Neighbour, 512>;

/// The order of nearest_by_radius()'s result.
enum class NearestOrder : std::uint8_t {
  kOfSearch,  ///< may change with nanoflann's version
  kOfPoints,  ///< depends on the points alone, as sums need it: costs a sort by index
};

/// Finds what KdTree::nearest() finds, but not nearest first: for 61 points with .46 of the instructions, and .69 with kOfPoints.
/// @param radius  of the first search. The fastest is 1.3 times the distance of the farthest point: 1.7 times as many points
/// @param wanted  1 to half of the room
template <class Accept>
std::span<const Neighbour> nearest_by_radius(const KdTree3& tree, const Vec3f& query, float radius,
                                             std::uint32_t wanted, NearestRoom& room, NearestOrder order,
                                             Accept accept) {
  constexpr float kWider = 1.6F;
  const std::span<Neighbour> found = room;
  for (int tries = 0; tries < 3; ++tries) {
    const std::size_t within = tree.within(query, radius * radius, found);
    const bool full = within == found.size();
    const auto kept = std::remove_if(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(within),
                                     [&](const Neighbour& n) { return !accept(n.index); });
    const auto count = static_cast<std::size_t>(kept - found.begin());
    if (!full && count >= wanted) {
      const auto all = found.first(count);
      if (order == NearestOrder::kOfPoints) std::ranges::sort(all, {}, &Neighbour::index);
      std::nth_element(all.begin(), all.begin() + wanted, all.end());
      return found.first(wanted);
    }
    radius = full ? radius / kWider : radius * kWider;
  }
  return found.first(tree.nearest(query, found.first(wanted), accept));
}

}  // namespace plumbline::inline slicer
