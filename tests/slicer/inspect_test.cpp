#include "slicer/inspect.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

struct Inspected {
  Inspected(const std::string& scan, const SliceSettings& settings, CoarseLook look = kNoLook) {
    ArenaBlock arena(64 * kMiB);
    MemorySource source(scan, "test.ply");
    ByteSource* const sources[] = {&source};
    status = inspect(sources, settings, *arena, nullptr, report, look);
    EXPECT_EQ(arena->used(), 0U);
  }
  InspectReport report;
  Status status;
};

/// A noisy sphere that stood on a table, with outliers on all sides and a piece of something else beside it.
Surface scanned_on_a_table() {
  Random random(4);
  Surface surface;
  for (const SurfacePoint& p : sphere(30'000, 10, {0, 0, 0})) {
    if (p.position[2] > -6) surface.push_back(p);
  }
  add_noise(surface, 0.03, 0.1, random);
  append(surface, sphere(300, 0.5, {18, 0, 5}));
  for (int i = 0; i < 300; ++i) {
    const Vec3d place(random.uniform(-15, 15), random.uniform(-15, 15), random.uniform(-12, 15));
    surface.push_back({place, random.vector().normalized()});
  }
  shuffle(surface, random);
  return surface;
}

void expect_agreement(const SliceSettings& settings) {
  const std::string scan = binary_ply(scanned_on_a_table());
  const Slicing sliced(scan, settings, 64 * kMiB);
  const SliceReport& slice = sliced.report();
  const Inspected inspected(scan, settings);
  const InspectReport& report = inspected.report;
  ASSERT_TRUE(inspected.status.has_value());
  ASSERT_TRUE(report.placement.has_value()) << report.placement.error().message();
  ASSERT_TRUE(report.sliced.has_value()) << report.sliced.error().message();
  EXPECT_EQ(report.placement->size_mm, slice.placement.size_mm);
  EXPECT_EQ(report.placement->grid.columns, slice.placement.grid.columns);
  EXPECT_EQ(report.placement->grid.rows, slice.placement.grid.rows);
  EXPECT_EQ(report.placement->grid.layers, slice.placement.grid.layers);
  EXPECT_EQ(report.coarse.flat_underside, slice.flat_underside);
  EXPECT_EQ(report.cloud_points, slice.cloud_points);
  EXPECT_EQ(report.strays.points, slice.strays.points);
  EXPECT_EQ(report.clustering.points, slice.clustering.points);
  EXPECT_EQ(ScanScale(slice.placement.scale)(report.lengths.noise).value, slice.lengths.noise.value);
  EXPECT_GT(slice.strays.points, 0U) << "the scan is to have a stray piece";
  EXPECT_TRUE(slice.flat_underside) << "and an open underside";
}

TEST(Inspect, AgreesWithSliceOnAScanWithOutliersAndAnOpenUnderside) { expect_agreement(settings_with_pitch(0.1F)); }

TEST(Inspect, AgreesWithSliceOnAPrinterAtAScale) {
  SliceSettings settings = settings_with_pitch(0.05F);
  settings.placement.printer = PrinterVolume{600, 600, 0.1F, 0.1F, 60};
  settings.placement.scale = 1.5;
  expect_agreement(settings);
}

TEST(Inspect, ShowsTheCoarseRRepWithWhatItRestsOn) {
  const std::string scan = binary_ply(scanned_on_a_table());
  int looks = 0;
  const auto look = [&](const RRep& rrep, const SliceReport& report) -> Status {
    ++looks;
    EXPECT_GT(rrep.grid.layers, 100U);
    EXPECT_LT(rrep.grid.columns, 200U);
    EXPECT_GT(report.confidence.shares().of(Evidence::kBase), 0.05);
    return {};
  };
  EXPECT_TRUE(Inspected(scan, settings_with_pitch(0.1F), look).status.has_value());
  EXPECT_EQ(looks, 1);
}

TEST(Inspect, SaysWhyAnObjectDoesNotFitAndSlicesItCoarselyAllTheSame) {
  SliceSettings settings = settings_with_pitch(0.05F);
  settings.placement.printer = PrinterVolume{100, 100, 0.1F, 0.1F, 60};
  const Inspected inspected(binary_ply(sphere(20'000, 10, {0, 0, 0})), settings);
  ASSERT_TRUE(inspected.status.has_value());
  ASSERT_FALSE(inspected.report.placement.has_value());
  EXPECT_EQ(inspected.report.placement.error().code(), ErrorCode::kDoesNotFit);
  EXPECT_TRUE(inspected.report.sliced.has_value());
}

TEST(Inspect, OfAScanWithoutASurfaceReportsWhatItMeasured) {
  const Surface dust(200, {Vec3d(1, 2, 3), Vec3d(0, 0, 1)});  // all in one place
  const Inspected inspected(binary_ply(dust), settings_with_pitch(0.1F));
  ASSERT_TRUE(inspected.status.has_value());
  EXPECT_EQ(inspected.report.scan.points, 200U);
  ASSERT_FALSE(inspected.report.sliced.has_value());
  EXPECT_EQ(inspected.report.sliced.error().code(), ErrorCode::kNoSurface);
  EXPECT_THAT(inspected.report.sliced.error().message(), HasSubstr("test.ply: no surface found in 200 points"));
}

}  // namespace
}  // namespace plumbline
