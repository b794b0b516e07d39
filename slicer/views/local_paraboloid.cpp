#include "slicer/views/local_paraboloid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "slicer/core/median.hpp"

namespace plumbline {
namespace {

/// Largest ratio of the least to the middle principal value of points on a surface; 1 is a ball or a line.
constexpr double kMaxFlatness = 0.15;
constexpr double kOutlierDeviations = 3;  ///< standard deviations beyond which points are left out
/// Added to the diagonal of the Gram matrix, per point: keeps it invertible where the points lie on a curve.
constexpr double kRidge = 1e-9;

}  // namespace

bool LocalParaboloid::fit(std::span<const Vec3d> points) {
  size = static_cast<std::uint32_t>(points.size());
  if (size < kMinPoints) return false;
  mean.setZero();
  for (const Vec3d& p : points) mean += p;
  mean /= size;
  Mat3d scatter = Mat3d::Zero();
  for (const Vec3d& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3d> solver(scatter);
  if (!(solver.eigenvalues()[0] < kMaxFlatness * solver.eigenvalues()[1])) return false;
  normal = solver.eigenvectors().col(0);
  const double scale = std::sqrt(solver.eigenvalues()[2] / size);
  for (std::uint32_t k = 0; k < size; ++k) {
    const Vec3d d = points[k] - mean;
    const double a = solver.eigenvectors().col(1).dot(d) / scale;
    const double b = solver.eigenvectors().col(2).dot(d) / scale;
    point[k] = k;
    terms[k] << 1, a, b, a * a, a * b, b * b;
    height[k] = normal.dot(d);
    weight[k] = 1;
  }
  solve();
  std::array<double, kMaxPoints> sizes;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  std::transform(residual.begin(), residual.begin() + size, sizes.begin(), [](double r) { return std::abs(r); });
  deviation = kMedianToDeviation * median(std::span(sizes).first(size));
  if (!(deviation > 0)) return false;
  std::uint32_t kept = 0;
  for (std::uint32_t k = 0; k < size; ++k) {
    if (std::abs(residual[k]) > kOutlierDeviations * deviation) continue;
    point[kept] = point[k];
    terms[kept] = terms[k];
    height[kept++] = height[k];
  }
  size = kept;
  if (size < kMinPoints) return false;
  solve();
  return true;
}

void LocalParaboloid::solve() {
  gram.setZero();
  Vec6d right = Vec6d::Zero();
  for (std::uint32_t k = 0; k < size; ++k) {
    gram += weight[k] * terms[k] * terms[k].transpose();
    right += weight[k] * height[k] * terms[k];
  }
  gram.diagonal().array() += kRidge * size;
  const Vec6d coefficients = gram.ldlt().solve(right);
  for (std::uint32_t k = 0; k < size; ++k) residual[k] = height[k] - coefficients.dot(terms[k]);
}

}  // namespace plumbline
