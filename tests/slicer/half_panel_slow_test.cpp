/// A million points on half of a panel, in the memory that a small board has.

#include <gtest/gtest.h>

#include "slicer/checks/stack_checker.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kHalfHeight = 10;  ///< mm

/// An ellipsoid over half of a panel.
Vec3d half_axes(const PrinterVolume& panel) {
  const double width = panel.columns * static_cast<double>(panel.pitch_x_mm);
  const double depth = panel.rows * static_cast<double>(panel.pitch_y_mm);
  const double share = std::sqrt(0.5 * 4 / kPi);  // of width and depth
  return {share * width / 2, share * depth / 2, kHalfHeight};
}

Surface ellipsoid(std::uint32_t points, const Vec3d& axes) {
  Surface surface = sphere(points, 1, {0, 0, 0});
  for (SurfacePoint& p : surface) {
    p.normal = p.position.cwiseQuotient(axes).normalized();
    p.position = p.position.cwiseProduct(axes);
  }
  return surface;
}

void expect_whole(const PrinterVolume& panel, std::size_t arena_mib) {
  const Vec3d axes = half_axes(panel);
  SliceSettings settings = settings_with_pitch(panel.pitch_x_mm);
  settings.placement.printer = panel;
  settings.placement.layer_height_mm = 0.1F;
  Slicing sliced(binary_ply(ellipsoid(1'000'000, axes)), settings, arena_mib * kMiB);
  const SliceReport& report = sliced.report();
  EXPECT_LT(report.cloud_points, report.cloud_capacity) << "thinned for want of room";
  EXPECT_GT(report.cloud_points, 900'000U);
  EXPECT_TRUE(report.components.counted);
  EXPECT_TRUE(report.features.counted);
  EXPECT_GT(sliced.rrep().crossings(), std::uint64_t{panel.columns} * panel.rows * 98 / 100);
  EXPECT_NEAR(sliced.volume() / (4.0 / 3 * kPi * axes.prod()), 1, 0.002);
  // What a print takes beside the R-Rep: masks and their checks.
  EXPECT_TRUE(MaskStream::create(sliced.rrep(), {}, sliced.arena()).has_value());
  EXPECT_TRUE(StackChecker::create(sliced.grid(), {}, sliced.arena()).has_value());
}

TEST(HalfPanelSlow, AMillionPointsOn4kFit96Mib) {
  expect_whole({.columns = 3840, .rows = 2400, .pitch_x_mm = 0.035F, .pitch_y_mm = 0.035F, .travel_mm = 160}, 96);
}

TEST(HalfPanelSlow, AMillionPointsOn8kFit256Mib) {
  expect_whole({.columns = 7680, .rows = 4320, .pitch_x_mm = 0.0285F, .pitch_y_mm = 0.0285F, .travel_mm = 230}, 256);
}

}  // namespace
}  // namespace plumbline
