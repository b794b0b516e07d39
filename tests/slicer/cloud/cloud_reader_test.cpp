#include "slicer/cloud/cloud_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "slicer/placement/placement.hpp"
#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

/// As PCL writes it, but for the compression: a block of literals alone.
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

CloudReadSettings for_a_2k_panel() {
  CloudReadSettings settings;
  settings.grid = panel_grid(PrinterVolume{1440, 2560, 0.04725F, 0.04725F, 160}, 0.05F);
  settings.winding_nodes = true;
  return settings;
}

// Its columns take 20 MB until the last one comes; the work space of the reader alone holds 45,000 points.
TEST(CloudReader, ReadsACompressedPcdOfAMillionPointsInTheArenaOfA2kPrinter) {
  const Surface surface = sphere(1'000'000, 30, {1, 2, 3});
  const std::string scan = compressed_pcd(surface);
  ArenaBlock arena(96 * kMiB);
  MemorySource source(scan, "sphere.pcd");
  const CloudReading read = value_of(read_cloud(source, for_a_2k_panel(), *arena, nullptr));
  ASSERT_EQ(read.cloud.size, surface.size());
  EXPECT_EQ(read.averaged, 0U);
  for (std::uint32_t i = 0; i < read.cloud.size; i += 997) {
    const Vec3d p = read.cloud.position[i].cast<double>() + read.offset;
    ASSERT_LT((p - surface[i].position).norm(), 1e-4);
    ASSERT_LT((read.cloud.normal[i].unpack().cast<double>() - surface[i].normal).norm(), 1e-4);
  }
  EXPECT_EQ(arena->bottom_used(), 0U);
}

TEST(CloudReader, RefusesACompressedPcdWhoseColumnsDoNotFitBeforeItsFirstPoint) {
  const std::string scan = compressed_pcd(sphere(300'000, 30, {0, 0, 0}));
  ArenaBlock arena(6 * kMiB);
  MemorySource source(scan, "sphere.pcd");
  const auto refused = read_cloud(source, {}, *arena, nullptr);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_THAT(refused.error().message(), HasSubstr("takes 5.8 MiB while it is read, the arena has 6.0 MiB"));
  EXPECT_THAT(refused.error().message(), HasSubstr("Save it as binary"));
  EXPECT_EQ(arena->used(), 0U);
}

// Nothing is lost: the same points without compression would be thinned as far.
TEST(CloudReader, ThinsACompressedPcdWhoseColumnsLeaveLittleRoom) {
  const std::string scan = compressed_pcd(sphere(300'000, 30, {0, 0, 0}));
  ArenaBlock arena(12 * kMiB);
  MemorySource source(scan, "sphere.pcd");
  const CloudReading read = value_of(read_cloud(source, {}, *arena, nullptr));
  EXPECT_EQ(read.scans.each[0].points, 300'000U);
  EXPECT_GT(read.averaged, 0U);
  EXPECT_LE(read.cloud.size, read.room);
  EXPECT_LE(read.plan.peak(), 12 * kMiB);
}

TEST(CloudReader, GivesBackWhatThePointsDidNotTake) {
  ArenaBlock arena(20 * kMiB);
  const Surface surface = sphere(50'000, 10, {0, 0, 0});
  const std::string scan = binary_ply(surface);
  CloudReadSettings settings;
  settings.winding_nodes = true;
  settings.first_cell = 1;  // some 2000 cells of 1 mm hold them all
  MemorySource source(scan, "sphere.ply");
  const CloudReading read = value_of(read_cloud(source, settings, *arena, nullptr));
  EXPECT_LT(read.cloud.size, 4000U);
  const std::uint32_t room = read.cloud.size + Cloud::spare(read.cloud.size);
  EXPECT_EQ(read.cloud.capacity(), room);
  EXPECT_LE(arena->used(), WindingTree::bytes_needed(room) + Cloud::kBytesPerPoint * room + 192);
  for (std::uint32_t i = 0; i < read.cloud.size; ++i) {
    const Vec3d p = read.cloud.position[i].cast<double>() + read.offset;
    ASSERT_NEAR(p.norm(), 10, 0.2);
    ASSERT_GT(read.cloud.normal[i].unpack().cast<double>().dot(p.normalized()), 0.99);
  }
}

TEST(CloudReader, CountsNoMorePointsThanHeaderAndFileAllow) {
  ScanHeader header;
  header.format = ScanFormat::kPly;
  header.encoding = "binary little endian";
  header.declared_points = 1000;
  EXPECT_EQ(most_points(header, std::nullopt), 1000U);
  EXPECT_EQ(most_points(header, 3'000'000), 1000U);
  EXPECT_EQ(most_points(header, 300), 101U);
  header.encoding = "ascii";
  EXPECT_EQ(most_points(header, 300), 51U);
  header.format = ScanFormat::kXyz;  // the count of a PTS is that of its first part
  EXPECT_EQ(most_points(header, 600'000), 100'001U);
  EXPECT_EQ(most_points(header, std::nullopt), std::nullopt);
  header.format = ScanFormat::kPcd;
  header.encoding = "binary compressed";
  header.reader_bytes = 100'000;
  EXPECT_EQ(most_points(header, 300), 1000U) << "a block of nothing but repetitions is short";
}

}  // namespace
}  // namespace plumbline
