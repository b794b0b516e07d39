#include "slicer/views/local_form.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "slicer/core/median.hpp"

namespace plumbline {
namespace {

constexpr double kFlat = 0.15;  ///< least principal value of points on a surface over the middle one, at most
constexpr double kOutlier = 3;  ///< deviations
constexpr double kHeld = 1e-9;  ///< of the diagonal of the Gram matrix: points on a curve have no paraboloid

}  // namespace

bool LocalForm::fit(std::span<const Vec3d> points) {
  size = static_cast<std::uint32_t>(points.size());
  if (size < kFewestPoints) return false;
  mean.setZero();
  for (const Vec3d& p : points) mean += p;
  mean /= size;
  Mat3d scatter = Mat3d::Zero();
  for (const Vec3d& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3d> solver(scatter);
  if (!(solver.eigenvalues()[0] < kFlat * solver.eigenvalues()[1])) return false;
  normal = solver.eigenvectors().col(0);
  const double reach = std::sqrt(solver.eigenvalues()[2] / size);
  for (std::uint32_t k = 0; k < size; ++k) {
    const Vec3d d = points[k] - mean;
    const double a = solver.eigenvectors().col(1).dot(d) / reach;
    const double b = solver.eigenvectors().col(2).dot(d) / reach;
    point[k] = k;
    terms[k] << 1, a, b, a * a, a * b, b * b;
    height[k] = normal.dot(d);
    weight[k] = 1;
  }
  solve();
  std::array<double, kMostPoints> sizes;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  std::transform(residual.begin(), residual.begin() + size, sizes.begin(), [](double r) { return std::abs(r); });
  deviation = kMedianToDeviation * median(std::span(sizes).first(size));
  if (!(deviation > 0)) return false;
  std::uint32_t kept = 0;
  for (std::uint32_t k = 0; k < size; ++k) {
    if (std::abs(residual[k]) > kOutlier * deviation) continue;
    point[kept] = point[k];
    terms[kept] = terms[k];
    height[kept++] = height[k];
  }
  size = kept;
  if (size < kFewestPoints) return false;
  solve();
  return true;
}

void LocalForm::solve() {
  gram.setZero();
  Vec6d right = Vec6d::Zero();
  for (std::uint32_t k = 0; k < size; ++k) {
    gram += weight[k] * terms[k] * terms[k].transpose();
    right += weight[k] * height[k] * terms[k];
  }
  gram.diagonal().array() += kHeld * size;
  const Vec6d form = gram.ldlt().solve(right);
  for (std::uint32_t k = 0; k < size; ++k) residual[k] = height[k] - form.dot(terms[k]);
}

}  // namespace plumbline
