#pragma once
/// The grid of a scanner's view: where a point of the scan lies in the view's image.

#include <cstdint>
#include <span>

#include "slicer/core/vec.hpp"

namespace plumbline {

/// A projection (u, v) = ((a0 + <a, x>) / q, (b0 + <b, x>) / q), q = 1 + <c, x>, of pixels: points of the view have whole u
/// and v. A camera without distortion, and a scanner that sweeps in parallel (c = 0), are such.
struct ViewGrid {
  Vec3f middle = Vec3f::Zero();           ///< what x is relative to, mm
  Eigen::Matrix<double, 11, 1> map = {};  ///< a, a0, b, b0, c; pixels per mm, pixels, 1/mm

  struct Pixel {
    double u, v, q;
  };
  Pixel project(const Vec3f& point) const;
  /// Distance from the nearest whole pixel, pixels; 1 for what the view has behind it.
  double off_grid(const Vec3f& point) const;
  /// Direction of the ray that a point was seen along, of length 1, either way.
  Vec3d ray(const Vec3f& point) const;
  /// The same projection with another middle; one that is before the camera.
  ViewGrid around(const Vec3f& other) const;
};

/// One step of fitting a grid to points of which some are of the view: Gauss and Newton's, each point weighted by Tukey's
/// biweight of its distance from the grid.
class ViewGridFit {
 public:
  /// @param width   pixels; points farther off the grid than this do not count
  /// @param extent  of the scan, mm: what the view's perspective is held small against where the points do not tell it
  ViewGridFit(const ViewGrid& grid, double width, double extent) : grid_(grid), width_(width), extent_(extent) {}
  void add(const Vec3f& point);
  /// @returns false, and `grid` as it was, where the points tell nothing
  bool improve(ViewGrid& grid) const;

 private:
  using Vec11d = Eigen::Matrix<double, 11, 1>;
  using Mat11d = Eigen::Matrix<double, 11, 11>;

  ViewGrid grid_;
  double width_;
  double extent_;
  // Sums over the points, weighted, of y y^T with y = (x, 1) / q; of the same times u, v, and u^2 + v^2; of y times the
  // distances du, dv from the grid, and times u du + v dv.
  Eigen::Matrix4d plain_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d by_u_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d by_v_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d by_square_ = Eigen::Matrix4d::Zero();
  Eigen::Vector4d off_u_ = Eigen::Vector4d::Zero();
  Eigen::Vector4d off_v_ = Eigen::Vector4d::Zero();
  Eigen::Vector4d off_both_ = Eigen::Vector4d::Zero();
};

}  // namespace plumbline
