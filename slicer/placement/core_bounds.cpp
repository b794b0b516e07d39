#include "slicer/placement/core_bounds.hpp"

#include <algorithm>

namespace plumbline {

Expected<Box3f> core_bounds(std::span<const Vec3f> points, Arena& arena) {
  const ArenaScope scope(arena);
  const auto sorted = arena.take_top<float>(points.size(), "reading the scan");
  PLUMBLINE_TRY(sorted);
  const auto left_out = static_cast<std::ptrdiff_t>(points.size() / 20);
  Vec3f low;
  Vec3f high;
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), sorted->begin(), [axis](const Vec3f& p) { return p[axis]; });
    const auto lowest = sorted->begin() + left_out;
    std::nth_element(sorted->begin(), lowest, sorted->end());
    low[axis] = *lowest;
    const auto highest = sorted->end() - 1 - left_out;
    std::nth_element(lowest, highest, sorted->end());
    high[axis] = *highest;
  }
  Box3f box;
  box.extend(low);
  box.extend(high);
  return box;
}

}  // namespace plumbline
