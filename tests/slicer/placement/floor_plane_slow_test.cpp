/// Real scans have no floor, whichever way up they lie.

#include <gtest/gtest.h>

#include <string>

#include "slicer/preparation.hpp"
#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/shared_scan.hpp"

namespace plumbline {
namespace {

using namespace testing;

class FloorOf : public ::testing::TestWithParam<const char*> {};

TEST_P(FloorOf, ARealScanIsNotFound) {
  const auto path = shared_scan(GetParam());
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const std::string bytes = content_of(path);
  for (const double degrees : {0.0, 90.0, -90.0, 180.0}) {
    ArenaBlock arena(200 * kMiB);
    MemorySource source(bytes, GetParam());
    ByteSource* const one[] = {&source};
    SliceSettings settings;
    settings.placement.rotation_degrees[0] = degrees;
    settings.placement.fit = true;
    PreparationReport report;
    const StageContext job{*arena, nullptr, report};
    const ReadScan read = value_of(read_points(ScanSources(one), set_threads(settings), job, report));
    check(prepare(read, set_threads(settings), job, report).map([](const auto&) {}));
    EXPECT_EQ(report.floor.points, 0U) << degrees;
  }
}

INSTANTIATE_TEST_SUITE_P(Scans, FloorOf,
                         ::testing::Values("bunny_raw.ply", "dragon_raw.ply", "ucicouple_front.ply", "gargoyle.ply",
                                           "baron_noisy.ply"));

}  // namespace
}  // namespace plumbline
