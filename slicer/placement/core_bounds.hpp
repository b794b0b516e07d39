#pragma once

#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/vec.hpp"

namespace plumbline {

/// Bounds of the points along each axis without a twentieth of them at either end. Stray pieces are less than that, so the object
/// reaches at least as far.
/// @param points  at least one
/// @retval ErrorCode::kOutOfMemory  no room for a number a point
[[nodiscard]] Expected<Box3f> core_bounds(std::span<const Vec3f> points, Arena& arena);

}  // namespace plumbline
