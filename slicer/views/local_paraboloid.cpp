#include "slicer/views/local_paraboloid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "slicer/core/numbers/lanes.hpp"
#include "slicer/core/numbers/median.hpp"

namespace plumbline::inline slicer {
namespace {

/// Largest ratio of the least to the middle principal value of points on a surface; 1 is a ball or a line.
constexpr double kMaxFlatness = 0.15;
constexpr double kOutlierDeviations = 3;  ///< standard deviations beyond which points are left out
/// Added to the diagonal of the Gram matrix, per point: keeps it invertible where the points lie on a curve.
constexpr double kRidge = 1e-9;

constexpr std::size_t kTerms = 6;

PLUMBLINE_INLINE void terms_of(const Lanes& a, const Lanes& b, Lanes* terms) {
  terms[0] = Lanes{} + 1;
  terms[1] = a;
  terms[2] = b;
  terms[3] = a * a;
  terms[4] = a * b;
  terms[5] = b * b;
}

struct Equations {
  std::array<float, kTerms*(kTerms + 1) / 2> products;  ///< lower half, row after row
  std::array<float, kTerms> right;
};

PLUMBLINE_WIDE void sum_up(const LocalParaboloid& surface, Equations& sums) {
  Lanes products[kTerms * (kTerms + 1) / 2] = {};  // NOLINT(cppcoreguidelines-avoid-c-arrays)
  Lanes right[kTerms] = {};                        // NOLINT(cppcoreguidelines-avoid-c-arrays)
  for (std::uint32_t k = 0; k < surface.size; k += kLanes) {
    Lanes a, b, height, weight;
    Lanes terms[kTerms];  // NOLINT(cppcoreguidelines-avoid-c-arrays)
    load(a, &surface.a[k]);
    load(b, &surface.b[k]);
    load(height, &surface.height[k]);
    load(weight, &surface.weight[k]);
    terms_of(a, b, terms);
    std::size_t at = 0;
    for (std::size_t i = 0; i < kTerms; ++i) {
      const Lanes weighted = weight * terms[i];
      right[i] += weighted * height;
      for (std::size_t j = 0; j <= i; ++j) products[at++] += weighted * terms[j];
    }
  }
  for (std::size_t i = 0; i < sums.products.size(); ++i) sums.products[i] = sum(products[i]);
  for (std::size_t i = 0; i < kTerms; ++i) sums.right[i] = sum(right[i]);
}

PLUMBLINE_WIDE void set_residuals(LocalParaboloid& surface, const float* coefficients) {
  for (std::uint32_t k = 0; k < surface.size; k += kLanes) {
    Lanes a, b, rest;
    Lanes terms[kTerms];  // NOLINT(cppcoreguidelines-avoid-c-arrays)
    load(a, &surface.a[k]);
    load(b, &surface.b[k]);
    load(rest, &surface.height[k]);
    terms_of(a, b, terms);
    for (std::size_t i = 0; i < kTerms; ++i) rest -= coefficients[i] * terms[i];
    store(&surface.residual[k], rest);
  }
}

}  // namespace

Vec6d LocalParaboloid::terms(std::uint32_t k) const {
  const auto at = static_cast<double>(a[k]);
  const auto up = static_cast<double>(b[k]);
  Vec6d terms;
  terms << 1, at, up, at * at, at * up, up * up;
  return terms;
}

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
  const Vec3d along_a = solver.eigenvectors().col(1) / scale;
  const Vec3d along_b = solver.eigenvectors().col(2) / scale;
  a.fill(0);
  b.fill(0);
  height.fill(0);
  for (std::uint32_t k = 0; k < size; ++k) {
    const Vec3d d = points[k] - mean;
    a[k] = static_cast<float>(along_a.dot(d));
    b[k] = static_cast<float>(along_b.dot(d));
    point[k] = k;
    height[k] = static_cast<float>(normal.dot(d));
  }
  std::fill(weight.begin(), weight.begin() + size, 1.0F);
  solve();
  std::array<float, kMaxPoints> sizes;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  std::transform(residual.begin(), residual.begin() + size, sizes.begin(), [](float r) { return std::abs(r); });
  deviation = kMedianToDeviation * static_cast<double>(median(std::span(sizes).first(size)));
  if (!(deviation > 0)) return false;
  std::uint32_t kept = 0;
  for (std::uint32_t k = 0; k < size; ++k) {
    if (static_cast<double>(std::abs(residual[k])) > kOutlierDeviations * deviation) continue;
    point[kept] = point[k];
    a[kept] = a[k];
    b[kept] = b[k];
    height[kept++] = height[k];
  }
  size = kept;
  if (size < kMinPoints) return false;
  solve();
  return true;
}

void LocalParaboloid::solve() {
  std::fill(weight.begin() + size, weight.end(), 0.0F);  // of the last lanes
  Equations sums;
  sum_up(*this, sums);
  Vec6d right;
  std::size_t at = 0;
  for (std::size_t i = 0; i < kTerms; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    right[row] = static_cast<double>(sums.right[i]);
    for (Eigen::Index j = 0; j <= row; ++j) gram(row, j) = gram(j, row) = static_cast<double>(sums.products[at++]);
  }
  gram.diagonal().array() += kRidge * size;
  const Vec6d coefficients = gram.ldlt().solve(right);
  const Eigen::Matrix<float, 6, 1> flat = coefficients.cast<float>();
  set_residuals(*this, flat.data());
}

}  // namespace plumbline::inline slicer
