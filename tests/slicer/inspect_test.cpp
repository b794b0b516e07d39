#include "slicer/inspect.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "slicer/preparation.hpp"
#include "slicer/slicer.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::Each;
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

/// Points on the x axis, a twentieth of a millimetre apart, that face up if they have normals.
Surface on_a_line(std::size_t points) {
  Surface line;
  for (std::size_t i = 0; i < points; ++i) line.push_back({Vec3d(0.05 * static_cast<double>(i), 2, 3), Vec3d::UnitZ()});
  return line;
}

std::string without_normals(const Surface& surface) {
  std::string text;
  for (const SurfacePoint& p : surface) {
    for (const double at : {p.position[0], p.position[1], p.position[2]}) text += std::to_string(at) + " ";
    text += "\n";
  }
  return text;
}

/// Expects that each stage begins before it advances.
class StageWatch final : public ProgressSink {
 public:
  void begin(Stage stage) override { running_ = stage; }
  bool advance(Stage stage, double /*fraction*/) override {
    EXPECT_EQ(running_, stage);
    return true;
  }
  void end(Stage /*stage*/, std::size_t /*peak*/) override { running_.reset(); }

 private:
  std::optional<Stage> running_;
};

/// What slice(), inspect() and prepare_normals(), which orient uses, say about a scan.
std::vector<std::string> said_about(const std::string& scan, const char* name) {
  SliceSettings settings = set_threads(settings_with_pitch(0.1F));
  settings.placement.size = PrintSize{Side::kLength, 20};  // so that nothing is too small
  const auto slice_it = [](ScanSources sources, const SliceSettings& with, Arena& arena) -> Status {
    SliceReport report;
    PLUMBLINE_TRY(slice(sources, with, arena, nullptr, report));
    return {};
  };
  const auto inspect_it = [](ScanSources sources, const SliceSettings& with, Arena& arena) -> Status {
    InspectReport report;
    return inspect(sources, with, arena, nullptr, report);
  };
  const auto orient_it = [](ScanSources sources, const SliceSettings& with, Arena& arena) -> Status {
    PreparationReport report;
    const auto look = [](const PreparedScan&, const SurfaceSamples&) -> Status { return {}; };
    StageWatch watch;
    return prepare_normals(sources, with, arena, &watch, report, look);
  };
  using Command = Status (*)(ScanSources, const SliceSettings&, Arena&);
  std::vector<std::string> said;
  for (const Command command : {Command(slice_it), Command(inspect_it), Command(orient_it)}) {
    ArenaBlock arena(64 * kMiB);
    MemorySource source(scan, name);
    ByteSource* const sources[] = {&source};
    const Status done = command(ScanSources(sources), settings, *arena);
    said.push_back(done ? "accepted" : std::string(done.error().message()));
  }
  return said;
}

TEST(Inspect, AndOrientRefuseWhatHasNoSurfaceInTheWordsOfSlice) {
  const Surface dust(200, {Vec3d(1, 2, 3), Vec3d(0, 0, 1)});  // all in one place
  Surface two(1, dust[0]);
  two.push_back({Vec3d(2, 3, 4), Vec3d::UnitX()});
  for (const std::string& scan : {binary_ply(Surface(1, dust[0])), binary_ply(dust)}) {
    EXPECT_THAT(said_about(scan, "test.ply"), Each(HasSubstr("test.ply: all of it lies at one place, 1 2 3")));
  }
  EXPECT_THAT(said_about(without_normals(dust), "test.xyz"), Each(HasSubstr("all of it lies at one place, 1 2 3")));
  for (const Surface& surface : {two, on_a_line(3), on_a_line(500), on_a_line(9000)}) {
    const std::string points = std::to_string(surface.size()) + " points";
    EXPECT_THAT(said_about(binary_ply(surface), "test.ply"),
                Each(HasSubstr("test.ply: no surface found in " + points)));
    EXPECT_THAT(said_about(without_normals(surface), "test.xyz"),
                Each(HasSubstr("test.xyz: no surface found in " + points)));
  }
}

TEST(Inspect, AndOrientAcceptASmallScan) {
  EXPECT_THAT(said_about(binary_ply(sphere(2000, 5, {0, 0, 0})), "test.ply"), Each(std::string("accepted")));
}

}  // namespace
}  // namespace plumbline
