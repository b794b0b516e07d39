#include "slicer/plan/memory_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "slicer/placement/placement.hpp"
#include "slicer/supports/drawing/grey_masks.hpp"
#include "slicer/supports/support_finder.hpp"
#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/admitted_cloud.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/views/scanned_views.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

PrintGrid panel(std::uint32_t columns, std::uint32_t rows) {
  PrintGrid grid;
  grid.columns = columns;
  grid.rows = rows;
  grid.layers = 3000;
  return grid;
}

TEST(MemoryPlan, NeedsAsMuchOrMoreInEveryStageForMorePoints) {
  for (const std::optional<PrintGrid>& grid : {std::optional<PrintGrid>(), std::optional(panel(1440, 2560))}) {
    MemoryPlan before = plan_memory(1, grid, 1);
    for (std::uint32_t points = 2; points < kMostPoints; points += points / 7 + 1) {
      const MemoryPlan plan = plan_memory(points, grid, 1);
      for (std::size_t s = 0; s < kStageCount; ++s)
        ASSERT_GE(plan.bytes[s], before.bytes[s]) << points << ", stage " << s;
      ASSERT_GT(plan.peak(), 24 * std::size_t{points});
      before = plan;
    }
  }
}

TEST(MemoryPlan, NeedsMoreForMoreThreadsAndLargerPanels) {
  const auto rays = static_cast<std::size_t>(Stage::kRays);
  EXPECT_GT(plan_memory(100000, panel(1440, 2560), 8).bytes[rays],
            plan_memory(100000, panel(1440, 2560), 1).bytes[rays]);
  EXPECT_GT(plan_memory(1000, panel(3840, 2400), 1).peak(), plan_memory(1000, panel(1440, 2560), 1).peak());
  // With few points the R-Rep stage needs more than the rays, and it runs in one thread.
  const auto rrep = static_cast<std::size_t>(Stage::kRRep);
  const MemoryPlan two = plan_memory(1000, panel(1440, 2560), 2);
  EXPECT_GT(two.bytes[rrep], two.bytes[rays]);
  EXPECT_EQ(two.bytes[rrep], plan_memory(1000, panel(1440, 2560), 1).bytes[rrep]);
}

TEST(MemoryPlan, KnowsOfGreyPixelsAndOfFourRays) {
  const PrintGrid grid = panel(1440, 2560);
  const auto with = [&](Grey grey) { return plan_memory(100000, grid, 1, {.grey = grey}); };
  const MemoryPlan off = with(Grey::kOff), vertical = with(Grey::kVertical), full = with(Grey::kFull);
  EXPECT_EQ(off.bytes, plan_memory(100000, grid, 1).bytes);
  const std::size_t greys = GreyMasks::bytes_needed(grid, most_struts(grid), Grey::kVertical);
  EXPECT_GT(greys, 2 * kMiB);
  EXPECT_EQ(vertical.of(Stage::kLayers), off.of(Stage::kLayers) + greys);
  EXPECT_EQ(vertical.of(Stage::kRays), off.of(Stage::kRays));
  const RayYield half{0.5 * grid.columns * grid.rows, grid.columns * static_cast<double>(grid.rows)};
  // Five rays a pixel on a quarter of the panel, instead of one on half of it.
  const RayYield quarter{half.rays / 2, half.crossings / 2};
  for (const Stage stage : {Stage::kSupports, Stage::kLayers}) {
    EXPECT_GE(full.of(stage) + rrep_bytes(grid, half), off.of(stage) + 5 * rrep_bytes(grid, quarter))
        << to_string(stage);
  }
  for (const Stage stage : {Stage::kRays, Stage::kRRep}) {
    EXPECT_GE(full.of(stage) + 2 * store_bytes(grid, half), off.of(stage) + 5 * store_bytes(grid, quarter))
        << to_string(stage);
  }
}

TEST(MemoryPlan, NamesTheStageOfItsPeak) {
  const MemoryPlan plan = plan_memory(500000, panel(1440, 2560), 2);
  EXPECT_EQ(plan.bytes[static_cast<std::size_t>(plan.widest())], plan.peak());
}

TEST(MemoryPlan, IsTheLargestThatFits) {
  for (const std::size_t mib : {64U, 96U, 500U}) {
    const MemoryPlan plan = value_of(largest_plan(mib * kMiB, std::nullopt, panel(1440, 2560), 2));
    EXPECT_LE(plan.peak(), mib * kMiB);
    ASSERT_LT(plan.points, kMostPoints);
    EXPECT_GT(plan_memory(plan.points + 1, panel(1440, 2560), 2, {.arena_bytes = mib * kMiB}).peak(), mib * kMiB);
  }
}

// Half of the panel covered, as for every plan before the scan is read.
TEST(MemoryPlan, HasRoomForAMillionPointsOn2kIn52MibOn4kIn96AndOn8kIn256) {
  EXPECT_GE(value_of(largest_plan(52 * kMiB, std::nullopt, panel(1440, 2560), 1)).points, 1'000'000U);
  PrintGrid four = panel(3840, 2400);
  four.layers = 3200;
  EXPECT_GE(value_of(largest_plan(96 * kMiB, std::nullopt, four, 1)).points, 1'000'000U);
  PrintGrid eight = panel(7680, 4320);
  eight.layers = 4600;
  EXPECT_GE(value_of(largest_plan(256 * kMiB, std::nullopt, eight, 1)).points, 1'000'000U);
}

TEST(MemoryPlan, PlansForNoMorePointsThanAreDeclaredAndAtLeastForTheFewest) {
  EXPECT_EQ(value_of(largest_plan(500 * kMiB, 123456, panel(1440, 2560), 1)).points, 123456U);
  EXPECT_EQ(value_of(largest_plan(500 * kMiB, 0, panel(1440, 2560), 1)).points, kFewestPoints);
  const std::uint64_t hostile = ~std::uint64_t{0};
  EXPECT_LE(value_of(largest_plan(100 * kMiB, hostile, panel(1440, 2560), 1)).peak(), 100 * kMiB);
}

TEST(MemoryPlan, RefusesAJobThatCannotFitAndNamesNeedAndBudget) {
  const auto refused = largest_plan(2 * kMiB, std::nullopt, panel(1440, 2560), 1);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_THAT(refused.error().message(), HasSubstr("the arena of 2.0 MiB"));
  EXPECT_THAT(refused.error().message(), HasSubstr("MiB even for a scan thinned to 1000 points"));
}

/// An ellipsoid that covers half of the panel, as the plan assumes.
Surface half_a_panel(double pitch, std::uint32_t columns, std::uint32_t rows, std::uint32_t points,
                     double noise = 0.02) {
  const double radius = std::min(columns, rows) * pitch * 0.4;
  Random random(1);
  Surface surface = sphere(points, radius, {0, 0, 0});
  const double longer = 0.5 / 0.503 * rows / columns;
  for (SurfacePoint& p : surface) {
    p.position[1] *= longer;
    p.normal[1] /= longer;
    p.normal.normalize();
  }
  if (noise > 0) add_noise(surface, noise, 0.05, random);
  shuffle(surface, random);
  return surface;
}

TEST(MemoryPlan, CoversWhatEachStageUses) {
  SliceSettings settings = settings_with_pitch(0.1F);
  settings.placement.printer = PrinterVolume{180, 320, 0.1F, 0.1F, 60};
  // Arenas that the cloud fills leave the plan no slack.
  for (const auto& [threads, mib] : {std::pair(1U, 7U), std::pair(4U, 17U)}) {
    settings.threads = threads;
    const Slicing sliced(binary_ply(half_a_panel(0.1, 180, 320, 100000)), settings, mib * kMiB);
    const SliceReport& report = sliced.report();
    EXPECT_GT(report.cloud_points, report.cloud_capacity / 2) << "the cloud does not fill the arena";
    for (std::size_t s = 0; s < kStageCount; ++s) {
      const auto stage = static_cast<Stage>(s);
      // The ray stage's store takes all free memory until it is closed.
      if (stage == Stage::kRays) continue;
      EXPECT_LE(report.peak_bytes[s], report.planned_bytes[s]) << to_string(stage);
    }
  }
}

struct PlannedJob {
  const char* scan;
  Surface surface;  ///< the file; further ones are in `more`
  bool confidence = false;
  std::optional<PrinterVolume> printer = std::nullopt;
  std::size_t arena_mib = 64;
  std::vector<Surface> more = {};
};

std::vector<PlannedJob> jobs_of_several_kinds() {
  constexpr std::uint32_t kPoints = 60000;
  Random random(5);
  std::vector<PlannedJob> jobs;
  const Surface clean = sphere(kPoints, 15, {1, 2, 3});
  jobs.push_back({"clean", clean});
  Surface noisy = clean;
  add_noise(noisy, 0.05, 0.1, random);
  shuffle(noisy, random);
  jobs.push_back({"noisy", noisy});
  jobs.push_back({"noisy, with its evidence", noisy, true});
  Surface without_normals = clean;
  for (SurfacePoint& p : without_normals) p.normal.setZero();
  jobs.push_back({"without normals", without_normals});
  Surface open = clean;
  std::erase_if(open, [](const SurfacePoint& p) { return p.position[2] < 0; });
  jobs.push_back({"open below", open});
  Surface outliers = clean;
  for (std::uint32_t i = 0; i < kPoints / 20; ++i) {
    outliers.push_back({Vec3d(1, 2, 3) + 8 * random.vector(), random.vector().normalized()});
  }
  shuffle(outliers, random);
  jobs.push_back({"with outliers", outliers});
  const PrinterVolume panel{360, 640, 0.1F, 0.1F, 60};
  const Surface half = half_a_panel(0.1, 360, 640, kPoints);
  jobs.push_back({"half of a panel", half, false, panel});
  jobs.push_back({"half of a panel, thinned", half_a_panel(0.1, 360, 640, 4 * kPoints), false, panel, 10});
  jobs.push_back({"half of a panel, joined further", half_a_panel(0.1, 360, 640, 3 * kPoints, 0), false, panel, 10});
  const ScannedViews scan = scan_ellipsoid({}, 1);
  std::vector<Surface> views(12);
  for (std::size_t i = 0; i < scan.view.size(); ++i) {
    views[scan.view[i]].push_back({scan.surface[i].position + Vec3d(30, 30, 30), scan.surface[i].normal});
  }
  jobs.push_back({"of several views", views[0]});
  jobs.back().more.assign(views.begin() + 1, views.end());
  return jobs;
}

TEST(MemoryPlan, IsWithinFivePerCentOfTheMostThatAJobUses) {
  for (const PlannedJob& job : jobs_of_several_kinds()) {
    SliceSettings settings = settings_with_pitch(0.1F);
    settings.placement.printer = job.printer;
    settings.confidence = job.confidence;
    std::vector<std::string> content = {binary_ply(job.surface)};
    for (const Surface& view : job.more) content.push_back(binary_ply(view));
    std::vector<MemorySource> files;
    for (const std::string& bytes : content) files.emplace_back(bytes, "test.ply");
    std::vector<ByteSource*> sources;
    for (MemorySource& file : files) sources.push_back(&file);
    const Slicing sliced(sources, settings, job.arena_mib * kMiB);
    const SliceReport& report = sliced.report();
    EXPECT_EQ(report.lengths.views_moved.value > 0, !job.more.empty()) << job.scan;
    const auto most = [](const auto& bytes) { return static_cast<double>(*std::ranges::max_element(bytes)); };
    const double used = most(report.peak_bytes);
    const double planned = most(report.planned_bytes);
    EXPECT_LE(used, planned) << job.scan;
    EXPECT_LE(planned, 1.05 * used) << job.scan;
    for (const Stage stage : {Stage::kViews, Stage::kWindingTree, Stage::kRayGrid, Stage::kRays, Stage::kRRep}) {
      const auto s = static_cast<std::size_t>(stage);
      EXPECT_LE(report.peak_bytes[s], report.planned_bytes[s]) << job.scan << ", " << to_string(stage);
      EXPECT_LE(static_cast<double>(report.planned_bytes[s]), 1.05 * static_cast<double>(report.peak_bytes[s]))
          << job.scan << ", " << to_string(stage);
    }
  }
}

/// A compressed PCD as PCL writes it, except that its block holds literals only.
std::string compressed_pcd(const Surface& surface) {
  std::string columns;
  for (int normal = 0; normal < 2; ++normal) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const SurfacePoint& p : surface) {
        columns += little(static_cast<float>(normal == 0 ? p.position[axis] : p.normal[axis]));
      }
    }
  }
  std::string block;
  for (std::size_t at = 0; at < columns.size(); at += 32) {
    const std::size_t count = std::min<std::size_t>(32, columns.size() - at);
    block += static_cast<char>(count - 1);
    block.append(columns, at, count);
  }
  const std::string points = std::to_string(surface.size());
  return "VERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\nCOUNT 1 1 1 1 1 "
         "1\nWIDTH " +
         points + "\nHEIGHT 1\nPOINTS " + points + "\nDATA binary_compressed\n" +
         little(static_cast<std::uint32_t>(block.size()), static_cast<std::uint32_t>(columns.size())) + block;
}

// The columns take 20 MB until the last one is read; the reader's work space alone would hold 45,000 points.
TEST(MemoryPlan, HasRoomForACompressedPcdOfAMillionPointsInTheArenaOfA2kPrinter) {
  const Surface surface = sphere(1'000'000, 30, {1, 2, 3});
  const std::string scan = compressed_pcd(surface);
  ArenaBlock arena(96 * kMiB);
  MemorySource source(scan, "sphere.pcd");
  const PrintGrid two_k = panel_grid(PrinterVolume{1440, 2560, 0.04725F, 0.04725F, 160}, 0.05F);
  const CloudReading read = value_of(read_admitted(source, *arena, two_k)).reading;
  ASSERT_EQ(read.cloud.size, surface.size());
  EXPECT_EQ(read.averaged, 0U);
  for (std::uint32_t i = 0; i < read.cloud.size; i += 997) {
    const Vec3d p = read.cloud.position[i].cast<double>() + read.offset;
    ASSERT_LT((p - surface[i].position).norm(), 1e-4);
    ASSERT_LT((read.cloud.normal[i].unpack().cast<double>() - surface[i].normal).norm(), 1e-4);
  }
  EXPECT_EQ(arena->bottom_used(), 0U);
}

TEST(MemoryPlan, RefusesACompressedPcdWhoseColumnsDoNotFitBeforeItsFirstPoint) {
  const std::string scan = compressed_pcd(sphere(300'000, 30, {0, 0, 0}));
  ArenaBlock arena(6 * kMiB);
  MemorySource source(scan, "sphere.pcd");
  const auto refused = read_admitted(source, *arena);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_THAT(refused.error().message(), HasSubstr("the arena of 6.0 MiB: this compressed scan stores its columns one "
                                                   "after another, and keeping them takes 5.8 MiB"));
  EXPECT_THAT(refused.error().message(), HasSubstr("Save it without compression"));
  EXPECT_EQ(arena->used(), 0U);
}

// The columns take no room from the points: uncompressed, the same scan would be thinned as far.
TEST(MemoryPlan, ThinsACompressedPcdWhoseColumnsLeaveLittleRoom) {
  const std::string scan = compressed_pcd(sphere(300'000, 30, {0, 0, 0}));
  ArenaBlock arena(12 * kMiB);
  MemorySource source(scan, "sphere.pcd");
  const AdmittedCloud read = value_of(read_admitted(source, *arena));
  EXPECT_EQ(read.reading.scans.each[0].points, 300'000U);
  EXPECT_GT(read.reading.averaged, 0U);
  EXPECT_LE(read.reading.cloud.size, read.plan.points);
  EXPECT_LE(read.plan.peak(), 12 * kMiB);
}

}  // namespace
}  // namespace plumbline
