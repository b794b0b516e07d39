#pragma once
/// Where a point of a surface moves if the outline of each layer is moved.

#include <algorithm>
#include <cmath>

#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// The move of a point, mm, sideways along its horizontal normal:
///
///     by_mm n_xy / max(|n_xy|, 0.1)
///
/// A nearly level surface, which it would not change, it moves less.
/// @param normal  outward, unit length
/// @param by_mm   outwards if above 0
inline Vec3f outline_move(const Vec3f& normal, float by_mm) {
  constexpr float kLevel = 0.1F;
  const float share = by_mm / std::max(kLevel, std::sqrt(normal[0] * normal[0] + normal[1] * normal[1]));
  return {share * normal[0], share * normal[1], 0};
}

}  // namespace plumbline::inline slicer
