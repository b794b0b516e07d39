#pragma once
/// Points near a place, in the form that lanes read.

#include <cstddef>
#include <span>

#include "slicer/core/numbers/vec.hpp"

namespace plumbline {

/// Points relative to a place, mm, as one list for each axis. The size is a multiple of kLanes.
struct LocalPoints {
  std::span<const float> x, y, z;
  std::size_t size() const { return x.size(); }
  Vec3f operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
};

}  // namespace plumbline
