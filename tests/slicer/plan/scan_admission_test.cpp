#include "slicer/plan/scan_admission.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "slicer/placement/placement.hpp"
#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/admitted_cloud.hpp"
#include "tests/slicer/support/arena_block.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

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
TEST(ScanAdmission, HasRoomForACompressedPcdOfAMillionPointsInTheArenaOfA2kPrinter) {
  const Surface surface = sphere(1'000'000, 30, {1, 2, 3});
  const std::string scan = compressed_pcd(surface);
  ArenaBlock arena(96 * kMiB);
  MemorySource source(scan, "sphere.pcd");
  const PrintGrid panel = panel_grid(PrinterVolume{1440, 2560, 0.04725F, 0.04725F, 160}, 0.05F);
  const CloudReading read = value_of(read_admitted(source, *arena, panel)).reading;
  ASSERT_EQ(read.cloud.size, surface.size());
  EXPECT_EQ(read.averaged, 0U);
  for (std::uint32_t i = 0; i < read.cloud.size; i += 997) {
    const Vec3d p = read.cloud.position[i].cast<double>() + read.offset;
    ASSERT_LT((p - surface[i].position).norm(), 1e-4);
    ASSERT_LT((read.cloud.normal[i].unpack().cast<double>() - surface[i].normal).norm(), 1e-4);
  }
  EXPECT_EQ(arena->bottom_used(), 0U);
}

TEST(ScanAdmission, RefusesACompressedPcdWhoseColumnsDoNotFitBeforeItsFirstPoint) {
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
TEST(ScanAdmission, ThinsACompressedPcdWhoseColumnsLeaveLittleRoom) {
  const std::string scan = compressed_pcd(sphere(300'000, 30, {0, 0, 0}));
  ArenaBlock arena(12 * kMiB);
  MemorySource source(scan, "sphere.pcd");
  const AdmittedCloud read = value_of(read_admitted(source, *arena));
  EXPECT_EQ(read.reading.scans.each[0].points, 300'000U);
  EXPECT_GT(read.reading.averaged, 0U);
  EXPECT_LE(read.reading.cloud.size, read.room);
  EXPECT_LE(read.plan.peak(), 12 * kMiB);
}

TEST(ScanAdmission, TakesRoomForNoMorePointsThanAreAnnounced) {
  ScanAdmission admission = value_of(ScanAdmission::create(64 * kMiB, std::nullopt, 1, false));
  EXPECT_EQ(value_of(admission.admit({.points = 5000})), 5000U);
  EXPECT_EQ(admission.plan().points, 5000U);
  EXPECT_EQ(value_of(admission.admit({.points = 0})), kFewestPoints);
  const std::uint32_t most = value_of(admission.admit({}));
  EXPECT_EQ(most, admission.room());
  EXPECT_EQ(value_of(admission.admit({.points = ~std::uint64_t{0}})), most);
}

}  // namespace
}  // namespace plumbline
