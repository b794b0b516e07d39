#pragma once
/// A point of a surface that knows its side.

#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

struct OrientedPoint {
  Vec3f at = Vec3f::Zero();
  Vec3f normal = Vec3f::UnitZ();  ///< outward, unit length
};

}  // namespace plumbline::inline slicer
