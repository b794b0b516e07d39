#pragma once
/// Fits tangent planes by principal components.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"

namespace plumbline::inline slicer {

/// Principal axes of points.
struct PrincipalAxes {
  Vec3d mean;      ///< from the place that they are seen from
  Vec3d variance;  ///< along each axis, times the number of points, ascending
  Mat3d axes;      ///< unit vectors, in columns
};
/// @param from  a place near the points, so that nothing large cancels
PrincipalAxes principal_axes(const Vec3f& from, std::span<const Neighbour> points, std::span<const Vec3f> positions);

/// Fits planes to one point after another. Consecutive points lie near each other, so each search starts with the number of
/// neighbours that the last plane needed. That saves time and changes no result.
class TangentPlanes {
 public:
  TangentPlanes(const Cloud& cloud, const KdTree3& tree) : cloud_(cloud), tree_(tree) {}

  /// Finds the nearest points of point i. The other functions are about that point.
  void look_at(std::uint32_t i);

  /// Radius of a disc with the area of the point's share of the surface, mm.
  float share_radius() const;

  /// Fits a plane to the nearest points (Hoppe et al., Surface Reconstruction from Unorganized Points, 1992, section 3.2): 20
  /// points, more if their residual from the plane is large for their distance.
  /// @returns its normal, facing either side; nothing if the points lie on a line or in one place
  std::optional<Vec3f> normal();

  /// The points that the plane was fitted to, nearest first, the point itself included.
  std::span<const Neighbour> points() const { return std::span(found_).first(used_); }

 private:
  /// Numbers of points to try. Few follow the surface's curvature, many average the noise.
  static constexpr std::array<std::uint32_t, 3> kPoints = {20, 40, 80};

  std::uint32_t search(std::size_t size);

  const Cloud& cloud_;
  const KdTree3& tree_;
  std::uint32_t at_ = 0;
  std::uint32_t have_ = 0;                       ///< nearest points found so far
  std::uint32_t used_ = 0;                       ///< points of the plane
  std::size_t expected_ = 0;                     ///< index into kPoints that the next point will probably need
  std::array<Neighbour, kPoints.back()> found_;  // NOLINT(cppcoreguidelines-pro-type-member-init)
};

}  // namespace plumbline::inline slicer
