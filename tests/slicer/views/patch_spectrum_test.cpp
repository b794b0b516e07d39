#include "slicer/views/patch_spectrum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "slicer/core/numbers/lanes.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(Phasor, LiesOnTheUnitCircleAtItsAngle) {
  for (int k = -4000; k <= 4000; ++k) {
    const float turns = static_cast<float>(k) * 0.00123F;
    const Phasor p = phasor(turns);
    const double angle = 2 * kPi * static_cast<double>(turns);
    ASSERT_NEAR(p.re, std::cos(angle), 3e-6) << turns;
    ASSERT_NEAR(p.im, std::sin(angle), 3e-6) << turns;
    const float back = angle_in_turns(p) - turns;
    ASSERT_NEAR(back - std::round(back), 0, 1e-3) << turns;
  }
}

constexpr double kPixel = 0.4;   ///< mm
constexpr double kRadius = 5.5;  ///< mm

bool in_patch(const Vec3d& p) { return p.head<2>().norm() < kRadius; }

/// Points on rays along +z that are kPixel apart, up to 0.5 mm off the plane, and `others` times as many random points.
std::vector<Vec3f> patch(double others) {
  Random random(1);
  std::vector<Vec3f> points;
  const auto half = static_cast<int>(kRadius / kPixel);
  for (int j = -half; j <= half; ++j) {
    for (int i = -half; i <= half; ++i) {
      const Vec3d p((i + 0.2) * kPixel, (j - 0.3) * kPixel, random.uniform(-0.5, 0.5));
      if (in_patch(p)) points.emplace_back(p.cast<float>());
    }
  }
  const auto all = static_cast<std::size_t>((1 + others) * static_cast<double>(points.size()));
  while (points.size() < all) {
    const Vec3d p(random.uniform(-kRadius, kRadius), random.uniform(-kRadius, kRadius), random.uniform(-0.5, 0.5));
    if (in_patch(p)) points.emplace_back(p.cast<float>());
  }
  return points;
}

/// Points as the spectrum reads them; the last few that don't fill the lanes are left out.
class PointLists {
 public:
  explicit PointLists(const std::vector<Vec3f>& points) {
    for (std::size_t i = 0; i < points.size() / kLanes * kLanes; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) lists_[axis].push_back(points[i][static_cast<Eigen::Index>(axis)]);
    }
  }
  LocalPoints operator*() const { return {lists_[0], lists_[1], lists_[2]}; }

 private:
  std::array<std::vector<float>, 3> lists_;
};

std::vector<SpectrumPeak> peaks_of(const std::vector<Vec3f>& points) {
  ArenaBlock block(4 * kMiB);
  PatchSpectrum spectrum = value_of(PatchSpectrum::create(*block));
  const auto spacing = static_cast<float>(kRadius * std::sqrt(kPi / static_cast<double>(points.size())));
  const auto peaks = spectrum.peaks(*PointLists(points), Vec3f::UnitZ(), static_cast<float>(kRadius), spacing);
  return {peaks.begin(), peaks.end()};
}

TEST(PatchSpectrum, AddsPhasorsAsTheScalarFunctionDoes) {
  const std::vector<Vec3f> points = patch(1);
  const std::size_t used = points.size() / kLanes * kLanes;
  for (const Vec3f& frequency : {Vec3f(1.3F, -0.4F, 0.2F), Vec3f(-0.7F, 2.1F, 5.0F), Vec3f(0.01F, 0, 0)}) {
    double re = 0;
    double im = 0;
    for (std::size_t i = 0; i < used; ++i) {
      const Phasor p = phasor(frequency.dot(points[i]));
      re += static_cast<double>(p.re) / static_cast<double>(used);
      im += static_cast<double>(p.im) / static_cast<double>(used);
    }
    const Phasor c = coefficient(*PointLists(points), frequency);
    EXPECT_NEAR(static_cast<double>(c.re), re, 1e-5);
    EXPECT_NEAR(static_cast<double>(c.im), im, 1e-5);
  }
}

TEST(PatchSpectrum, ShowsThePixelsOfAViewAmongSixTimesAsManyPoints) {
  const std::vector<Vec3f> points = patch(6);
  const auto peaks = peaks_of(points);
  ASSERT_GE(peaks.size(), 2U);
  for (const Vec3f& wanted : {Vec3f(Vec3f::UnitX() / kPixel), Vec3f(Vec3f::UnitY() / kPixel)}) {
    EXPECT_TRUE(std::any_of(peaks.begin(), peaks.end(), [&](const SpectrumPeak& p) {
      const Vec3f off = p.frequency - wanted * (p.frequency.dot(wanted) < 0 ? -1.0F : 1.0F);
      return off.head<2>().norm() < 0.02F && std::abs(off[2]) < 0.15F;
    })) << wanted.transpose();
  }
  // A seventh of the points belong to the view, so the power is 1/49 of the number of points.
  EXPECT_NEAR(power_at(*PointLists(points), Vec3f::UnitX() / kPixel), static_cast<float>(points.size()) / 49, 20);
}

TEST(PatchSpectrum, ShowsNoPeaksOfRandomPoints) {
  std::vector<Vec3f> points = patch(6);
  points.erase(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(points.size() / 7 + 1));
  EXPECT_LE(peaks_of(points).size(), 1U);
}

}  // namespace
}  // namespace plumbline
