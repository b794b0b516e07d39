#include "slicer/placement/base_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kPitch = 0.2;  ///< mm

/// A box of 10 x 10 x 8 mm without the part below a plane that rises by `slope` along x.
Surface box_cut_off(double slope) {
  Random random(7);
  const Surface whole = box({0, 0, 0}, {10, 10, 8}, 0.15, 0.3, random);
  Surface open;
  std::copy_if(whole.begin(), whole.end(), std::back_inserter(open),
               [&](const SurfacePoint& p) { return p.position[2] > 1e-9 + slope * p.position[0]; });
  return open;
}

/// Area of the layer at a height, mm^2. The height is in scan coordinates, mm.
double area_at(const Slicing& slicing, double height) {
  double area = 0;
  slicing.for_each_section([&](std::uint32_t k, ConstBitImage section) {
    if (std::abs(slicing.middle_of(0, 0, k)[2] - height) <= 0.5 * static_cast<double>(slicing.grid().layer_height_mm)) {
      area = static_cast<double>(section.count()) * kPitch * kPitch;
    }
  });
  return area;
}

Slicing sliced(const Surface& surface, BaseChoice base) {
  SliceSettings settings = settings_with_pitch(static_cast<float>(kPitch));
  settings.base = base;
  return Slicing(binary_ply(surface), settings, 64 * kMiB);
}

TEST(BaseChoice, AutoClosesAnOpenUndersideFlat) {
  const Surface open = box_cut_off(0);
  const Slicing by_itself = sliced(open, BaseChoice::kAuto);
  const Slicing flat = sliced(open, BaseChoice::kFlat);
  EXPECT_TRUE(by_itself.report().flat_underside);
  EXPECT_TRUE(flat.report().flat_underside);
  EXPECT_NEAR(by_itself.volume(), 800, 8);
  EXPECT_TRUE(std::ranges::equal(by_itself.rrep().packed, flat.rrep().packed));
}

TEST(BaseChoice, NoneClosesASlopingRimAlongTheRim) {
  const Surface slanted = box_cut_off(0.3);
  const Slicing none = sliced(slanted, BaseChoice::kNone);
  EXPECT_FALSE(none.report().flat_underside);
  EXPECT_EQ(none.rays(RayDecision::kBase), 0U);
  EXPECT_NEAR(area_at(none, 4.5), 100, 0.5) << "mm^2: nothing inside the walls is missing";
  EXPECT_LT(none.volume(), 800 - 150 + 80) << "the closing bulges by less than 0.8 mm, since it continues the walls";
  const Slicing flat = sliced(slanted, BaseChoice::kFlat);
  EXPECT_TRUE(flat.report().flat_underside);
  EXPECT_GT(flat.volume(), none.volume() + 50) << "it reaches down to the plane, the shorter wall does not";
}

TEST(BaseChoice, DoesNotChangeAClosedObject) {
  const Surface closed = sphere(sphere_points(5, 0.15), 5, {0, 0, 0});
  const Slicing by_itself = sliced(closed, BaseChoice::kAuto);
  const Slicing none = sliced(closed, BaseChoice::kNone);
  const Slicing flat = sliced(closed, BaseChoice::kFlat);
  EXPECT_FALSE(none.report().flat_underside);
  EXPECT_NEAR(none.volume(), by_itself.volume(), 0.005 * by_itself.volume());
  EXPECT_TRUE(flat.report().flat_underside);
  EXPECT_NEAR(flat.volume(), by_itself.volume(), 0.005 * by_itself.volume());
}

}  // namespace
}  // namespace plumbline
