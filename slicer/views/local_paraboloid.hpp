#pragma once
/// A paraboloid through the points around a place.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

using Vec6d = Eigen::Matrix<double, 6, 1>;
using Mat6d = Eigen::Matrix<double, 6, 6>;

/// Height over the points' plane as a polynomial of second degree: least squares, repeated without points that lie more
/// than 3 standard deviations off.
struct LocalParaboloid {
  static constexpr std::uint32_t kMaxPoints = 80;  ///< a multiple of kLanes
  static constexpr std::uint32_t kMinPoints = 30;  ///< five for each of the six coefficients

  Vec3d mean = Vec3d::Zero();                   ///< of all points, mm
  Vec3d normal = Vec3d::Zero();                 ///< unit normal of their plane; its sign is arbitrary
  double deviation = 0;                         ///< standard deviation from the paraboloid, from the median, mm
  std::uint32_t size = 0;                       ///< number of points kept; for each of them:
  std::array<std::uint32_t, kMaxPoints> point;  ///< index in the input
  std::array<float, kMaxPoints> a, b;           ///< coordinates in the plane, over the points' extent there
  std::array<float, kMaxPoints> height;         ///< over the plane, mm
  std::array<float, kMaxPoints> residual;       ///< height over the paraboloid, mm
  std::array<float, kMaxPoints> weight;         ///< 1 after fit(); callers may change it and call solve()
  Mat6d gram = Mat6d::Zero();                   ///< sum of weight times terms times terms^T

  /// 1, a, b, a^2, a b, b^2 of a kept point.
  Vec6d terms(std::uint32_t k) const;

  /// @param points  mm, kMaxPoints at most
  /// @returns false if there are too few points, if they lie on no surface, or exactly on one
  bool fit(std::span<const Vec3d> points);
  /// Fits the paraboloid to the kept points with their present weights.
  void solve();
};

}  // namespace plumbline::inline slicer
