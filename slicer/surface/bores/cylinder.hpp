#pragma once
/// Cylinders fitted to points.

#include <Eigen/Core>

#include "slicer/core/numbers/vec.hpp"

namespace plumbline {

/// Positions along the axis are measured from `middle`, in the direction of `axis`.
struct Cylinder {
  Vec3f middle = Vec3f::Zero();  ///< a point of the axis
  Vec3f axis = Vec3f::UnitZ();   ///< unit vector
  float radius = 0;

  Vec3f on_axis(float along) const { return middle + axis * along; }
};

/// A point in the coordinates of a cylinder.
struct OnCylinder {
  float along = 0;                  ///< position along the axis
  float distance = 0;               ///< from the axis
  Vec3f outwards = Vec3f::UnitX();  ///< unit vector from the axis to the point; the x axis for a point on the axis
};

OnCylinder cylinder_coordinates(const Cylinder& cylinder, const Vec3f& point);

/// One Gauss-Newton step towards the cylinder of least squared distances (Shakarji, Least-squares fitting algorithms of
/// the NIST algorithm testing system, 1998, section 6). It moves and tilts the axis and changes the radius.
class CylinderFit {
 public:
  explicit CylinderFit(const Cylinder& start);

  /// @param point  in the coordinates of the start
  void add(const OnCylinder& point, float weight);

  /// Applies the step. What the points don't determine stays as it is.
  /// @param cylinder  the start; changed
  /// @returns false if there are no points, or if the step exceeds the cylinder's diameter
  bool improve(Cylinder& cylinder) const;

 private:
  using Vec5d = Eigen::Matrix<double, 5, 1>;
  using Mat5d = Eigen::Matrix<double, 5, 5>;

  Vec3f t_;  ///< t_ and s_ are perpendicular to the axis
  Vec3f s_;
  float radius_;
  Mat5d products_ = Mat5d::Zero();
  Vec5d residuals_ = Vec5d::Zero();
  double weight_ = 0;
};

}  // namespace plumbline
