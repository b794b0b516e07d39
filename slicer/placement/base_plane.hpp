#pragma once
/// Where an object stood while it was scanned.

#include <span>

#include "slicer/core/vec.hpp"

namespace plumbline {

/// Height of the plane that an object stood on, from the points of its walls.
///
/// Walls end at that plane, and noise blurs where: a point in two lies below the place at which the density of points over height
/// has risen to half of what it is above. Where it rises slowly the object has a tip and no rim, and the plane touches the tip.
/// A dozen strays below count for nothing either way.
///
/// @param points      print coordinates, mm; at least one
/// @param resolution  mm, above 0: the layer height. The rise is looked for at a fifth of it
/// @returns mm, not below the lowest point
[[nodiscard]] float base_plane(std::span<const Vec3f> points, float resolution);

}  // namespace plumbline
