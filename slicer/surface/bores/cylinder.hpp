#pragma once
/// Cylinders through points.

#include <Eigen/Core>

#include "slicer/core/vec.hpp"

namespace plumbline {

/// A place along its axis is told from the middle, in the direction of the axis.
struct Cylinder {
  Vec3f middle = Vec3f::Zero();  ///< a point of the axis
  Vec3f axis = Vec3f::UnitZ();   ///< unit
  float radius = 0;

  Vec3f on_axis(float along) const { return middle + axis * along; }
};

/// A point as a cylinder sees it.
struct OnCylinder {
  float along = 0;
  float distance = 0;               ///< from the axis
  Vec3f outwards = Vec3f::UnitX();  ///< unit, from the axis to the point; any that lies on it has the x axis
};

OnCylinder seen_from(const Cylinder& cylinder, const Vec3f& point);

/// One step of Gauss and Newton towards the cylinder of least squared distances (Shakarji, Least-squares fitting algorithms of
/// the NIST algorithm testing system, 1998, section 6): the axis is moved and tilted, the radius changed.
class CylinderFit {
 public:
  explicit CylinderFit(const Cylinder& start);

  /// @param point  as the start sees it
  void add(const OnCylinder& point, float weight);

  /// What the points do not tell stays as it is.
  /// @param cylinder  the start; moved
  /// @returns false: there are no points, or they ask for a step of more than its diameter
  bool improve(Cylinder& cylinder) const;

 private:
  using Vec5d = Eigen::Matrix<double, 5, 1>;
  using Mat5d = Eigen::Matrix<double, 5, 5>;

  Vec3f t_;  ///< across the axis
  Vec3f s_;
  float radius_;
  Mat5d products_ = Mat5d::Zero();
  Vec5d residuals_ = Vec5d::Zero();
  double weight_ = 0;
};

}  // namespace plumbline
