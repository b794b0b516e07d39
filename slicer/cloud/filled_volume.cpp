#include "slicer/cloud/filled_volume.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kSamples = 400;  ///< the quartile moves by 0.02 from sample to sample

struct Around {
  double roundness = 0;
  double inner_roundness = 0;
  double growth = 0;
};

/// Points around one that are looked at: four times as many as there are where they fill a volume evenly. Of more, those that the search
/// finds first.
constexpr std::size_t kMostAround = 4096;

/// The points of a ball.
struct Moments {
  void add(const Vec3d& d) {
    ++count;
    sum += d;
    products += d * d.transpose();
  }
  double roundness() const {
    // compute(), as in principal_axes().
    const Eigen::SelfAdjointEigenSolver<Mat3d> solver(products - sum * (sum.transpose() / count),
                                                      Eigen::EigenvaluesOnly);
    return solver.eigenvalues()[0] / solver.eigenvalues()[2];
  }
  double count = 0;
  Vec3d sum = Vec3d::Zero();
  Mat3d products = Mat3d::Zero();
};

Around look_around(const Cloud& cloud, const KdTree3& tree, const Vec3f& p, float reach) {
  Moments inner;
  Moments outer;
  std::array<Neighbour, kMostAround> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (const Neighbour& n : std::span(found).first(tree.within(p, reach * reach, found))) {
    const Vec3d between = (cloud.position[n.index] - p).cast<double>();
    outer.add(between);
    if (4 * n.distance2 <= reach * reach) inner.add(between);
  }
  return {outer.roundness(), inner.roundness(), outer.count / inner.count};
}

}  // namespace

PointSpread point_spread(const Cloud& cloud, const KdTree3& tree) {
  std::array<double, kSamples> roundness;
  std::array<double, kSamples> inner_roundness;
  std::array<double, kSamples> growth;
  std::size_t used = 0;
  const std::uint32_t samples = std::min(kSamples, cloud.size);
  for (std::uint32_t sample = 0; sample < samples; ++sample) {
    const std::uint32_t i = cloud.sampled(sample, samples);
    std::array<Neighbour, 17> found;  // the point itself is one
    const std::uint32_t count = tree.nearest(cloud.position[i], found);
    if (count < found.size() || !(found.back().distance2 > 0)) continue;
    const Around around = look_around(cloud, tree, cloud.position[i], 4 * std::sqrt(found.back().distance2));
    roundness[used] = around.roundness;
    inner_roundness[used] = around.inner_roundness;
    growth[used++] = around.growth;
  }
  if (used == 0) return {};
  const auto end = static_cast<std::ptrdiff_t>(used);
  std::sort(roundness.begin(), roundness.begin() + end);
  std::sort(inner_roundness.begin(), inner_roundness.begin() + end);
  std::sort(growth.begin(), growth.begin() + end);
  return {roundness[used * 3 / 4], inner_roundness[used * 3 / 4], growth[used / 2]};
}

}  // namespace plumbline::inline slicer
