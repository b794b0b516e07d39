#include "slicer/cloud/tangent_plane.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

/// A neighbourhood suffices if its radius is at least this many residuals. A right edge has 5.3, a ball of points 2.2.
constexpr double kReachInResiduals = 4;
/// Its second variance must also be at least this share of the first. A disc has 1, a half disc 0.28, a scan line nearly 0.
constexpr double kLeastWidth = 0.05;
/// Below this share of the first variance, the points lie on a line or in one place: there is no plane.
constexpr double kLine = 1e-6;

struct Plane {
  Vec3d normal = Vec3d::Zero();
  double flatness = -1;  ///< second variance divided by the least; negative: no plane
  bool sufficient = false;
};

Plane fit_plane(const Vec3f& point, std::span<const Neighbour> neighbours, const Cloud& cloud) {
  const PrincipalAxes found = principal_axes(point, neighbours, cloud.position);
  const Vec3d& variance = found.variance;
  Plane plane;
  if (!(variance[1] > kLine * variance[2])) return plane;
  const double least = std::max(variance[0], 1e-12 * variance[2]);
  plane.normal = found.axes.col(0);
  plane.flatness = variance[1] / least;
  const auto reach2 = static_cast<double>(neighbours.back().distance2);
  const double residual2 = least / static_cast<double>(neighbours.size());
  plane.sufficient =
      reach2 >= kReachInResiduals * kReachInResiduals * residual2 && variance[1] >= kLeastWidth * variance[2];
  return plane;
}

}  // namespace

PrincipalAxes principal_axes(const Vec3f& from, std::span<const Neighbour> points, std::span<const Vec3f> positions) {
  const auto count = static_cast<double>(points.size());
  Vec3d sum = Vec3d::Zero();
  Mat3d products = Mat3d::Zero();
  for (const Neighbour& n : points) {
    const Vec3d d = (positions[n.index] - from).cast<double>();
    sum += d;
    products += d * d.transpose();
  }
  // compute(), not computeDirect(): the closed form uses sines, which differ between C libraries.
  const Eigen::SelfAdjointEigenSolver<Mat3d> solver(products - sum * (sum.transpose() / count));
  return {sum / count, solver.eigenvalues(), solver.eigenvectors()};
}

/// @returns how many of the wanted kPoints[size] there are
std::uint32_t TangentPlanes::search(std::size_t size) {
  if (have_ < kPoints[size]) {
    have_ = tree_.nearest(cloud_.position[at_], std::span(found_).first(kPoints[std::max(size, expected_)]));
  }
  return std::min(have_, kPoints[size]);
}

void TangentPlanes::look_at(std::uint32_t i) {
  at_ = i;
  have_ = 0;
  used_ = search(0);
}

float TangentPlanes::share_radius() const {
  const std::uint32_t count = std::min(have_, kPoints[0]);
  return std::sqrt(found_[count - 1].distance2 / static_cast<float>(count));
}

std::optional<Vec3f> TangentPlanes::normal() {
  Plane best;
  for (std::size_t size = 0; size < kPoints.size(); ++size) {
    const std::uint32_t count = search(size);
    if (count < 3) break;
    const Plane plane = fit_plane(cloud_.position[at_], std::span(found_).first(count), cloud_);
    if (plane.flatness > best.flatness) {
      best = plane;
      used_ = count;
    }
    if (plane.sufficient || size + 1 == kPoints.size()) expected_ = size;
    if (plane.sufficient || count < kPoints[size]) break;
  }
  if (best.flatness < 0) return std::nullopt;
  return best.normal.cast<float>();
}

}  // namespace plumbline::inline slicer
