#include "slicer/views/view_grid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

/// Least q: points closer to the camera than this share of the middle's distance don't belong to its view. Avoids
/// dividing by 0.
constexpr double kMinQ = 0.05;
// Prior on the perspective c, for points that don't determine it: a camera stands some extents away.
constexpr double kPixelNoise = 0.05;        ///< pixels
constexpr double kLikelyPerspective = 0.6;  ///< standard deviation of c times the extent
constexpr double kRidge = 1e-9;  ///< share of the trace added to the diagonal, which keeps the matrix invertible

}  // namespace

ViewGrid::Pixel ViewGrid::project(const Vec3f& point) const {
  const Vec3d x = (point - middle).cast<double>();
  const double q = 1 + map.segment<3>(8).dot(x);
  if (q < kMinQ) return {0, 0, 0};
  return {(map.segment<3>(0).dot(x) + map[3]) / q, (map.segment<3>(4).dot(x) + map[7]) / q, q};
}

double ViewGrid::distance_from_grid(const Vec3f& point) const {
  const Pixel p = project(point);
  if (p.q == 0) return 1;
  const double u = p.u - std::floor(p.u + 0.5);
  const double v = p.v - std::floor(p.v + 0.5);
  return std::sqrt(u * u + v * v);
}

Vec3d ViewGrid::ray(const Vec3f& point) const {
  const Pixel p = project(point);
  const Vec3d along_u = map.segment<3>(0) - p.u * map.segment<3>(8);
  const Vec3d along_v = map.segment<3>(4) - p.v * map.segment<3>(8);
  return along_u.cross(along_v).normalized();
}

ViewGrid ViewGrid::around(const Vec3f& other) const {
  const Pixel p = project(other);
  ViewGrid moved;
  moved.middle = other;
  moved.map = map / p.q;
  moved.map[3] = p.u;
  moved.map[7] = p.v;
  return moved;
}

void ViewGridFit::add(const Vec3f& point) {
  const ViewGrid::Pixel p = grid_.project(point);
  if (p.q == 0) return;
  const double u = p.u - std::floor(p.u + 0.5);
  const double v = p.v - std::floor(p.v + 0.5);
  const double rest = 1 - (u * u + v * v) / (width_ * width_);
  if (rest <= 0) return;
  const double w = rest * rest;
  const Vec3d x = (point - grid_.middle).cast<double>() / extent_;
  const Eigen::Vector4d y = Eigen::Vector4d(x[0], x[1], x[2], 1) / p.q;
  const Eigen::Vector4d weighted = y * w;
  const Eigen::Matrix4d square = weighted * y.transpose();
  plain_ += square;
  by_u_ += square * p.u;
  by_v_ += square * p.v;
  by_square_ += square * (p.u * p.u + p.v * p.v);
  off_u_ += weighted * u;
  off_v_ += weighted * v;
  off_both_ += weighted * (p.u * u + p.v * v);
}

bool ViewGridFit::improve(ViewGrid& grid) const {
  if (!(plain_.trace() > 0)) return false;
  Mat11d held = Mat11d::Zero();
  Vec11d target;
  held.block<4, 4>(0, 0) = plain_;
  held.block<4, 4>(4, 4) = plain_;
  held.block<4, 3>(0, 8) = -by_u_.leftCols<3>();
  held.block<4, 3>(4, 8) = -by_v_.leftCols<3>();
  held.block<3, 4>(8, 0) = -by_u_.topRows<3>();
  held.block<3, 4>(8, 4) = -by_v_.topRows<3>();
  held.block<3, 3>(8, 8) = by_square_.topLeftCorner<3, 3>();
  target << off_u_, off_v_, -off_both_.head<3>();
  held.diagonal().array() += kRidge * plain_.trace();
  const double perspective = kPixelNoise * kPixelNoise / (kLikelyPerspective * kLikelyPerspective);
  for (int k = 8; k < 11; ++k) {
    held(k, k) += perspective;
    target[k] += perspective * grid.map[k] * extent_;
  }
  const Vec11d step = held.ldlt().solve(target);
  if (!step.allFinite()) return false;
  for (int k = 0; k < 11; ++k) grid.map[k] -= k == 3 || k == 7 ? step[k] : step[k] / extent_;
  return true;
}

}  // namespace plumbline
