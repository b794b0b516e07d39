#include "slicer/surface/bores/cylinder.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace plumbline {
namespace {

/// Added to the diagonal of the normal equations, over the weight of the points: keeps the parameters that they don't
/// determine.
constexpr double kRidge = 1e-4;
constexpr double kMaxStep = 2;  ///< radii; a larger step has left the points

}  // namespace

OnCylinder cylinder_coordinates(const Cylinder& cylinder, const Vec3f& point) {
  const Vec3f d = point - cylinder.middle;
  OnCylinder seen;
  seen.along = d.dot(cylinder.axis);
  const Vec3f across = d - cylinder.axis * seen.along;
  seen.distance = std::sqrt(across.dot(across));
  if (seen.distance > 0) seen.outwards = across / seen.distance;
  return seen;
}

CylinderFit::CylinderFit(const Cylinder& start) : radius_(start.radius) {
  const Frame frame(start.axis);
  t_ = frame.t;
  s_ = frame.s;
}

void CylinderFit::add(const OnCylinder& point, float weight) {
  const double t = point.outwards.dot(t_);
  const double s = point.outwards.dot(s_);
  const double along = point.along / radius_;  // so that tilts and shifts both are lengths at the wall
  Vec5d change;
  change << t, s, along * t, along * s, 1;
  const double w = weight;
  products_ += change * change.transpose() * w;
  residuals_ += change * (w * (point.distance - radius_));
  weight_ += w;
}

bool CylinderFit::improve(Cylinder& cylinder) const {
  if (!(weight_ > 0)) return false;
  Mat5d held = products_;
  held.diagonal().array() += kRidge * weight_;
  const Vec5d step = held.ldlt().solve(residuals_);
  if (!(step.cwiseAbs().maxCoeff() < kMaxStep * radius_)) return false;
  const Eigen::Matrix<float, 5, 1> by = step.cast<float>();
  cylinder.middle += t_ * by[0] + s_ * by[1];
  const Vec3f axis = cylinder.axis + (t_ * by[2] + s_ * by[3]) / radius_;
  cylinder.axis = axis / std::sqrt(axis.dot(axis));
  cylinder.radius += by[4];
  return cylinder.radius > 0;
}

}  // namespace plumbline
