#pragma once
/// Vectors are Eigen's. Its explicit vectorisation is off: on some machines it sums in another order or fuses multiply
/// and add, and the masks must be the same bits on all of them.

#ifndef EIGEN_DONT_VECTORIZE
#error "compile with EIGEN_DONT_VECTORIZE: the target plumbline::core sets it"
#endif
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace plumbline::inline slicer {

using Vec2f = Eigen::Vector2f;
using Vec3f = Eigen::Vector3f;
using Vec3d = Eigen::Vector3d;
using Mat3d = Eigen::Matrix3d;
using Mat4d = Eigen::Matrix4d;

/// Axis-aligned box, in the unit of its points. Empty until extend() is called.
template <class Vec>
struct Box {
  using Scalar = typename Vec::Scalar;
  Vec low = Vec::Constant(std::numeric_limits<Scalar>::max());
  Vec high = Vec::Constant(std::numeric_limits<Scalar>::lowest());

  bool empty() const { return !(low[0] <= high[0]); }
  void extend(const Vec& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Vec size() const { return high - low; }
  Vec centre() const { return (low + high) * Scalar(0.5); }
};
using Box3f = Box<Vec3f>;
using Box3d = Box<Vec3d>;

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

}  // namespace plumbline::inline slicer
