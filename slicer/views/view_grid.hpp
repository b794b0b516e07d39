#pragma once
/// The pixel grid of a view: where a point of the scan lies in the view's image.

#include <cstdint>
#include <span>

#include "slicer/core/vec.hpp"

namespace plumbline {

/// Projection of a point to pixels: (u, v) = ((a0 + <a, x>) / q, (b0 + <b, x>) / q) with q = 1 + <c, x>. Points of the
/// view have integer u and v. This covers a camera without distortion, and with c = 0 a scanner that sweeps in
/// parallel.
struct ViewGrid {
  Vec3f middle = Vec3f::Zero();           ///< origin of x, mm
  Eigen::Matrix<double, 11, 1> map = {};  ///< a, a0, b, b0, c; pixels per mm, pixels, 1/mm

  struct Pixel {
    double u, v, q;
  };
  /// @returns q = 0 for points behind the camera
  Pixel project(const Vec3f& point) const;
  /// Distance from the nearest integer pixel, pixels; 1 for points behind the camera.
  double distance_from_grid(const Vec3f& point) const;
  /// Unit vector along the ray that the point was seen on; its sign is arbitrary.
  Vec3d ray(const Vec3f& point) const;
  /// The same projection with another origin, which must be in front of the camera.
  ViewGrid around(const Vec3f& other) const;
};

/// One Gauss-Newton step that fits a grid to points, not all of which belong to the view. Each point has Tukey's
/// biweight of its distance from the grid.
class ViewGridFit {
 public:
  /// @param width   pixels; points farther from the grid don't count
  /// @param extent  size of the scan, mm: scale of the prior that keeps perspective small where the points don't
  ///                determine it
  ViewGridFit(const ViewGrid& grid, double width, double extent) : grid_(grid), width_(width), extent_(extent) {}
  void add(const Vec3f& point);
  /// @returns false, and leaves `grid` unchanged, if the points don't determine a step
  bool improve(ViewGrid& grid) const;

 private:
  using Vec11d = Eigen::Matrix<double, 11, 1>;
  using Mat11d = Eigen::Matrix<double, 11, 11>;

  ViewGrid grid_;
  double width_;
  double extent_;
  // Weighted sums over the points, with y = (x, 1) / q and (du, dv) the distance from the grid: of y y^T; of the same
  // times u, v and u^2 + v^2; of y times du, dv and u du + v dv.
  Eigen::Matrix4d plain_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d by_u_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d by_v_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d by_square_ = Eigen::Matrix4d::Zero();
  Eigen::Vector4d off_u_ = Eigen::Vector4d::Zero();
  Eigen::Vector4d off_v_ = Eigen::Vector4d::Zero();
  Eigen::Vector4d off_both_ = Eigen::Vector4d::Zero();
};

}  // namespace plumbline
