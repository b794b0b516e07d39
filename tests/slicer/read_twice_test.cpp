#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/slicer/reader/formats/e57_file.hpp"
#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/splat_files.hpp"

namespace plumbline::testing {
namespace {

std::string e57_ball(double radius_mm) {
  E57TestScan scan{.packet = 64 * 1500};
  std::array<std::vector<double>, 3> metres;
  for (const SurfacePoint& p : sphere(8000, radius_mm, {0, 0, 0})) {
    for (std::size_t a = 0; a < 3; ++a) metres[a].push_back(p.position[static_cast<Eigen::Index>(a)] / 1000);
  }
  for (std::size_t a = 0; a < 3; ++a) {
    scan.columns.push_back(double_column(std::string("cartesian") + static_cast<char>('X' + a), metres[a]));
  }
  return E57File().bytes({scan});
}

std::string splat_ball(double radius) {
  std::vector<Splat> splats;
  for (const SurfacePoint& p : sphere(8000, radius, {0, 0, 0})) {
    splats.push_back({.position = p.position, .turn = turn_from_z(p.normal[2] < 0 ? Vec3d(-p.normal) : p.normal)});
  }
  return splat_ply(splats);
}

TEST(ReadTwice, ScansThroughAPipeGiveTheSameCrossings) {
  for (const auto& [name, bytes] : {std::pair{"ball.e57", e57_ball(5)}, std::pair{"ball.ply", splat_ball(5)}}) {
    const SliceSettings settings = settings_with_pitch(0.25F);
    const Slicing file(MemorySource(bytes, name), settings, 32 * kMiB);
    MemorySource source(bytes, name);
    source.be_a_pipe();
    const Slicing pipe(source, settings, 32 * kMiB);
    EXPECT_TRUE(std::ranges::equal(file.rrep().packed, pipe.rrep().packed)) << name;
    EXPECT_GT(file.rrep().packed.size(), 1000U) << name;
    const double volume = 4.0 / 3 * 3.14159265358979 * 125;
    EXPECT_NEAR(file.volume() / volume, 1, 0.02) << name;
  }
}

TEST(ReadTwice, AnE57MayFollowAnotherFile) {
  const std::string first = binary_ply(sphere(4000, 5, {0, 0, 0}));
  const std::string second = e57_ball(5);
  const std::string third = splat_ball(5);
  MemorySource a(first, "a.ply"), b(second, "b.e57"), c(third, "c.ply");
  ByteSource* const all[] = {&a, &b, &c};
  ArenaBlock arena(32 * kMiB);
  SliceReport report;
  const auto rrep = slice(ScanSources(all), settings_with_pitch(0.25F), *arena, nullptr, report);
  ASSERT_TRUE(rrep.has_value()) << rrep.error().message();
  ASSERT_EQ(report.scans.count, 3U);
  EXPECT_EQ(report.scans.each[0].points, 4000U);
  EXPECT_EQ(report.scans.each[1].points, 8000U);
  EXPECT_EQ(report.scans.each[2].points, 8000U);
}

}  // namespace
}  // namespace plumbline::testing
