#include "slicer/reader/scan_sources.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/slicer/support/admitted_cloud.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

/// A sphere in two files, cut at `first` points.
struct Halves {
  explicit Halves(std::uint32_t points, std::uint32_t first) : whole(sphere(points, 10, {0, 0, 0})) {
    top = binary_ply(Surface(whole.begin(), whole.begin() + first));
    bottom = binary_ply(Surface(whole.begin() + first, whole.end()));
  }
  Surface whole;
  std::string top;
  std::string bottom;
};

/// As XYZ without normals.
std::string text_of(const Surface& surface) {
  std::string text;
  for (const SurfacePoint& p : surface) {
    for (int axis = 0; axis < 3; ++axis) text += std::to_string(p.position[axis]) + (axis < 2 ? " " : "\n");
  }
  return text;
}

struct Sliced {
  explicit Sliced(std::vector<MemorySource> files, std::size_t arena_bytes = 64 * kMiB) : arena(arena_bytes) {
    std::vector<ByteSource*> sources;
    for (MemorySource& file : files) sources.push_back(&file);
    rrep = slice(sources, settings_with_pitch(0.2F), *arena, nullptr, report);
  }
  ArenaBlock arena;
  SliceReport report;
  Expected<RRep> rrep;
};

TEST(ScanSources, GiveTheSameObjectAsOneFile) {
  const Halves halves(30'000, 11'000);
  const std::string whole = binary_ply(halves.whole);
  const Sliced one({MemorySource(whole, "whole.ply")});
  const Sliced two({MemorySource(halves.top, "top.ply"), MemorySource(halves.bottom, "bottom.ply", {100, 7000})});
  ASSERT_TRUE(one.rrep.has_value());
  ASSERT_TRUE(two.rrep.has_value()) << two.rrep.error().message();
  EXPECT_TRUE(std::ranges::equal(one.rrep->packed, two.rrep->packed));
  EXPECT_TRUE(std::ranges::equal(one.rrep->first, two.rrep->first));
  EXPECT_EQ(two.report.scan.points, 30'000U);
  EXPECT_EQ(two.report.scan.bytes, halves.top.size() + halves.bottom.size());
  ASSERT_EQ(two.report.scans.count, 2U);
  EXPECT_EQ(two.report.scans.each[0].points, 11'000U);
  EXPECT_EQ(two.report.scans.each[1].points, 19'000U);
}

TEST(ScanSources, ArePlannedAndThinnedTogether) {
  const Halves halves(300'000, 150'000);
  const std::string whole = binary_ply(halves.whole);
  const auto read = [&](std::vector<MemorySource> files, std::size_t arena_bytes) {
    std::vector<ByteSource*> sources;
    for (MemorySource& file : files) sources.push_back(&file);
    ArenaBlock arena(arena_bytes);
    return value_of(read_admitted(sources, *arena));
  };
  const MemorySource one(whole, "whole.ply");
  const MemorySource top(halves.top, "top.ply");
  const MemorySource bottom(halves.bottom, "bottom.ply");
  constexpr std::size_t kForHalf = 11 * kMiB;  // either half would fit; both do not
  const AdmittedCloud half = read({top}, kForHalf);
  EXPECT_EQ(half.reading.averaged, 0U);
  const AdmittedCloud thinned = read({top, bottom}, kForHalf);
  EXPECT_GT(thinned.reading.averaged, 0U);
  EXPECT_LE(thinned.reading.cloud.size, thinned.plan.points);
  EXPECT_LE(thinned.plan.peak(), kForHalf);
  // With enough room, the plan is that of all points together.
  EXPECT_EQ(read({top, bottom}, 100 * kMiB).plan.points, read({one}, 100 * kMiB).plan.points);
}

TEST(ScanSources, NameTheFileWithTheError) {
  const Halves halves(20'000, 9000);
  const std::string cut = halves.bottom.substr(0, halves.bottom.size() / 2);
  const MemorySource top(halves.top, "top.ply");
  const Sliced truncated({top, MemorySource(cut, "cut.ply")});
  ASSERT_FALSE(truncated.rrep.has_value());
  EXPECT_EQ(truncated.rrep.error().code(), ErrorCode::kTruncated);
  EXPECT_THAT(truncated.rrep.error().message(), HasSubstr("cut.ply"));
  const Sliced no_scan({top, MemorySource("%PDF-1.4 not a scan at all", "letter.pdf"), top});
  ASSERT_FALSE(no_scan.rrep.has_value());
  EXPECT_THAT(no_scan.rrep.error().message(), HasSubstr("letter.pdf"));
  MemorySource pulled(halves.bottom, "pulled.ply");
  pulled.fail_at(0);
  const Sliced gone({top, pulled});
  ASSERT_FALSE(gone.rrep.has_value());
  EXPECT_EQ(gone.rrep.error().code(), ErrorCode::kCannotRead);
  const std::string far = text_of({{{0, 0, 0}, {0, 0, 1}}, {{1e30, 0, 0}, {0, 0, 1}}});
  const Sliced far_away({top, MemorySource(far, "far.xyz")});
  ASSERT_FALSE(far_away.rrep.has_value());
  EXPECT_THAT(far_away.rrep.error().message(), HasSubstr("far.xyz: point 2 lies at"));
  // None has a surface, so the message names all of them.
  const std::string dust = text_of(Surface(40, SurfacePoint{{0, 0, 0}, {0, 0, 1}}));
  const Sliced nothing({MemorySource(dust, "a.xyz"), MemorySource(dust, "b.xyz"), MemorySource(dust, "c.xyz")});
  ASSERT_FALSE(nothing.rrep.has_value());
  EXPECT_THAT(nothing.rrep.error().message(), HasSubstr("a.xyz and 2 more"));
  for (const Sliced* sliced : {&truncated, &no_scan, &gone, &far_away, &nothing}) {
    EXPECT_EQ(const_cast<Sliced*>(sliced)->arena->used(), 0U);
  }
}

TEST(ScanSources, MayHaveNormalsInOneFileAndNoneInAnother) {
  const Halves halves(30'000, 15'000);
  const std::string text = text_of(Surface(halves.whole.begin() + 15'000, halves.whole.end()));
  const Sliced sliced({MemorySource(halves.top, "top.ply"), MemorySource(text, "bottom.xyz")});
  ASSERT_TRUE(sliced.rrep.has_value()) << sliced.rrep.error().message();
  EXPECT_EQ(sliced.report.scan.without_normal, 15'000U);
  EXPECT_GT(sliced.report.normals.estimated, 14'000U);
  const double volume = static_cast<double>(sliced.report.components.voxels) * 0.2 * 0.2 * 0.2;
  EXPECT_NEAR(volume, 4.0 / 3 * kPi * 1000, 40);
}

TEST(ScanSources, MayHaveUnknownSizes) {
  const Halves halves(20'000, 9000);
  MemorySource top(halves.top, "top.ply");
  MemorySource bottom(halves.bottom, "bottom.ply");
  top.forget_size();
  bottom.forget_size();
  const Sliced sliced({top, bottom});
  ASSERT_TRUE(sliced.rrep.has_value()) << sliced.rrep.error().message();
  EXPECT_EQ(sliced.report.scan.points, 20'000U);
}

}  // namespace
}  // namespace plumbline
