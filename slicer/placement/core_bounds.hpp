#pragma once

#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Bounds of the points along each axis without a twentieth of them at either end. Stray pieces are less than that, so the object
/// reaches at least as far.
/// @param points  at least one
/// @retval ErrorCode::kOutOfMemory  no room for a number a point
[[nodiscard]] Expected<Box3f> core_bounds(std::span<const Vec3f> points, Arena& arena);

/// Bounds of the object in a scan that has just been read, to name its size before its surface is known: those of the largest
/// piece of touching cells. A cell is an 8th to a 64th of the core's longest side, the finer the more points there are, and holds at least
/// four points and a 16th of the average. So flying points and distant pieces don't count.
/// @param points  at least one
/// @param core    core_bounds() of them
/// @retval ErrorCode::kOutOfMemory  no room for half a MiB of cells
[[nodiscard]] Expected<Box3f> dense_bounds(std::span<const Vec3f> points, const Box3f& core, Arena& arena);

}  // namespace plumbline::inline slicer
