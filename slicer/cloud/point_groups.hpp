#pragma once
/// Groups of neighbouring points, by halving.

#include <algorithm>
#include <span>

#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Halves points across the longest side of their bounding box, and each half again, until a part is a group. Reorders the points.
/// @param position  position(point): its Vec3f
/// @param is_group  is_group(points, side): whether they are halved no more; `side` is the longest of their box
/// @param use       use(group), in the order of the halves
template <class Point, class Position, class IsGroup, class Use>
void for_each_group(std::span<Point> points, Position position, IsGroup is_group, Use use) {
  Box3f box;
  for (const Point& p : points) box.extend(position(p));
  Eigen::Index axis = 0;
  const float side = box.size().maxCoeff(&axis);
  if (points.size() < 2 || is_group(points, side)) {
    use(points);
    return;
  }
  const std::size_t half = points.size() / 2;
  std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(half), points.end(),
                   [&](const Point& a, const Point& b) { return position(a)[axis] < position(b)[axis]; });
  for_each_group(points.first(half), position, is_group, use);
  for_each_group(points.subspan(half), position, is_group, use);
}

}  // namespace plumbline::inline slicer
