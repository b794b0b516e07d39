#pragma once
/// A right-handed frame about a direction.

#include <Eigen/Geometry>
#include <cmath>

#include "slicer/core/vec.hpp"

namespace plumbline {

/// Unit vectors t and s perpendicular to a unit vector n, with n x t = s. Of all frames about n, t is the projection of
/// the coordinate axis along which n is shortest.
struct Frame {
  Vec3f t;
  Vec3f s;

  explicit Frame(const Vec3f& n) {
    const int least = std::abs(n[0]) < std::abs(n[1]) ? (std::abs(n[0]) < std::abs(n[2]) ? 0 : 2)
                                                      : (std::abs(n[1]) < std::abs(n[2]) ? 1 : 2);
    const Vec3f across = Vec3f(Vec3f::Unit(least)) - n * n[least];
    t = across / std::sqrt(across.dot(across));
    s = n.cross(t);
  }

  Vec3f at(float cosine, float sine) const { return t * cosine + s * sine; }
};

}  // namespace plumbline
