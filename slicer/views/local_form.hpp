#pragma once
/// A paraboloid through the points round a place.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/vec.hpp"

namespace plumbline {

using Vec6d = Eigen::Matrix<double, 6, 1>;
using Mat6d = Eigen::Matrix<double, 6, 6>;

/// Heights over the plane of the points as a polynomial of second degree, least squares, once more without what lies 3
/// standard deviations off.
struct LocalForm {
  static constexpr std::uint32_t kMostPoints = 80;
  static constexpr std::uint32_t kFewestPoints = 30;

  Vec3d mean = Vec3d::Zero();                    ///< of all points, mm
  Vec3d normal = Vec3d::Zero();                  ///< of their plane, on either side
  double deviation = 0;                          ///< of the heights from the paraboloid, as their median tells it, mm
  std::uint32_t size = 0;                        ///< points that count; of each of them:
  std::array<std::uint32_t, kMostPoints> point;  ///< its place in the input
  std::array<Vec6d, kMostPoints> terms;          ///< 1, a, b, a^2, a b, b^2 of its place (a, b) in the plane
  std::array<double, kMostPoints> height;        ///< over the plane, mm
  std::array<double, kMostPoints> residual;      ///< height over the paraboloid, mm
  std::array<double, kMostPoints> weight;        ///< 1 after fit(), and the caller's to change
  Mat6d gram = Mat6d::Zero();                    ///< sum of weight times terms times terms

  /// @param points  mm, kMostPoints at most
  /// @returns false where they are too few, or lie on no surface, or exactly on one
  bool fit(std::span<const Vec3d> points);
  /// The paraboloid of the points that count with the weights that they have now.
  void solve();
};

}  // namespace plumbline
