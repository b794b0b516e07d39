#include "slicer/cloud/cloud_reader.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(CloudReader, ReleasesTheRoomThatNoPointTook) {
  ArenaBlock arena(20 * kMiB);
  const Surface surface = sphere(50'000, 10, {0, 0, 0});
  const std::string scan = binary_ply(surface);
  const CloudReadSettings settings{.first_cell = 1};  // some 2000 cells of 1 mm hold them all
  MemorySource source(scan, "sphere.ply");
  ByteSource* const sources[] = {&source};
  const auto room_for_all = [](const ScanAnnouncement& announced) {
    return Expected<std::uint32_t>(static_cast<std::uint32_t>(announced.points.value()));
  };
  const CloudReading read = value_of(read_cloud(sources, settings, room_for_all, *arena, nullptr));
  EXPECT_LT(read.cloud.size, 4000U);
  EXPECT_EQ(read.cloud.capacity(), read.cloud.size);
  EXPECT_LE(arena->used(),
            Cloud::kBytesPerSeenPoint * read.cloud.size + kMaxViews * (sizeof(Vec3f) + sizeof(bool)) + 384);
  for (std::uint32_t i = 0; i < read.cloud.size; ++i) {
    const Vec3d p = read.cloud.position[i].cast<double>() + read.offset;
    ASSERT_NEAR(p.norm(), 10, 0.2);
    ASSERT_GT(read.cloud.normal[i].unpack().cast<double>().dot(p.normalized()), 0.99);
  }
}

TEST(CloudReader, AsksForRoomOnceWithWhatAllHeadersAnnounce) {
  const std::string scan = binary_ply(sphere(1000, 10, {0, 0, 0}));
  MemorySource first(scan, "first.ply");
  MemorySource second(scan, "second.ply");
  ByteSource* const sources[] = {&first, &second};
  ArenaBlock arena(4 * kMiB);
  int asked = 0;
  const auto room = [&](const ScanAnnouncement& announced) {
    ++asked;
    EXPECT_EQ(announced.points, 2000U);
    EXPECT_GT(announced.kept_bytes, 0U) << "the header of the second file";
    return Expected<std::uint32_t>(1500);
  };
  const CloudReading read = value_of(read_cloud(sources, {}, room, *arena, nullptr));
  EXPECT_EQ(asked, 1);
  EXPECT_LE(read.cloud.size, 1500U);
  EXPECT_GT(read.averaged, 0U);
}

TEST(CloudReader, TellsFilesApart) {
  const std::string ply = binary_ply(sphere(1000, 10, {0, 0, 0}));
  const std::string pcd = "VERSION 0.7\nFIELDS x y z\nWIDTH 2\nVIEWPOINT 1 2 3 1 0 0 0\nDATA ascii\n0 0 99\n0 0 98\n";
  MemorySource first(ply, "first.ply");
  MemorySource second(pcd, "second.pcd");
  MemorySource third(ply, "third.ply");
  ArenaBlock arena(4 * kMiB);
  const auto room = [&](const ScanAnnouncement&) { return Expected<std::uint32_t>(5000); };
  ByteSource* const sources[] = {&first, &second, &third};
  const CloudReading read = value_of(read_cloud(sources, {}, room, *arena, nullptr));
  const CloudViews& views = read.cloud.views;
  EXPECT_EQ(views.count, 3U);
  EXPECT_EQ(std::vector<bool>(views.has_scanner.begin(), views.has_scanner.begin() + 3),
            std::vector<bool>({false, true, false}));
  EXPECT_LT((views.scanner[1].cast<double>() + read.offset - Vec3d(1, 2, 3)).norm(), 1e-5);
  EXPECT_EQ(read.cloud.view_of(999), 0);
  EXPECT_EQ(read.cloud.view_of(1000), 1);
  EXPECT_EQ(read.cloud.view_of(1002), 2);
  MemorySource alone(ply, "alone.ply");
  ByteSource* const one[] = {&alone};
  const Cloud cloud = value_of(read_cloud(one, {}, room, *arena, nullptr)).cloud;
  EXPECT_TRUE(cloud.views.are_runs);
  EXPECT_EQ(cloud.view_of(0), 0);
  EXPECT_EQ(cloud.view_of(999), kRuns - 1);
}

TEST(CloudReader, ReturnsTheErrorOfARefusedRoomAndLeavesTheArenaAsItWas) {
  const std::string scan = binary_ply(sphere(1000, 10, {0, 0, 0}));
  MemorySource source(scan, "sphere.ply");
  ByteSource* const sources[] = {&source};
  ArenaBlock arena(4 * kMiB);
  const auto refuse = [](const ScanAnnouncement&) -> Expected<std::uint32_t> {
    return fail(ErrorCode::kOutOfMemory, "no room");
  };
  const auto refused = read_cloud(sources, {}, refuse, *arena, nullptr);
  ASSERT_FALSE(refused.has_value());
  EXPECT_STREQ(refused.error().message(), "no room");
  EXPECT_EQ(arena->used(), 0U);
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
  header.is_packed = true;
  EXPECT_EQ(most_points(header, 300), 1000U) << "a compressed block of repetitions is short";
}

}  // namespace
}  // namespace plumbline
