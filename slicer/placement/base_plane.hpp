#pragma once
/// Finds the plane on which an object stood while it was scanned.

#include <span>

#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Height of the base plane, from the points of the object's walls.
///
/// Walls end at the base plane, but noise blurs their ends. The plane lies where the density of points over height rises to
/// half of its value in the walls. If it rises slowly, the object has a tip instead of a rim, and the plane touches the tip.
/// Up to a dozen outliers below are ignored in either case.
///
/// @param points      print coordinates, mm; at least one
/// @param resolution  mm, above 0: the layer height. The height is found to a fifth of it
/// @returns mm, not below the lowest point that is no outlier
[[nodiscard]] float base_plane(std::span<const Vec3f> points, float resolution);

}  // namespace plumbline::inline slicer
