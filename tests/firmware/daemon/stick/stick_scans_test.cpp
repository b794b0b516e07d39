/// What of a stick is offered.

#include "firmware/daemon/stick/stick_scans.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/daemon/stick/scan_series.hpp"
#include "firmware/io/scan_names.hpp"

namespace plumbline {
namespace {

TEST(ScanName, IsKnownByItsEnding) {
  for (const char* name : {"a.ply", "A.PLY", "b.xyzrgb", "c.xyz", "points.txt", "d.asc", "e.csv", "part.STL", "f.off"})
    EXPECT_TRUE(is_scan_name(name)) << name;
  for (const char* name : {".ply", "job.toml", "a.ctb", "README.txt", "Read me.txt", "LICENSE.txt"}) {
    EXPECT_FALSE(is_scan_name(name)) << name;
  }
}

TEST(ScanSeries, HasNamesThatDifferInANumberOrASide) {
  using Series = std::vector<std::vector<std::size_t>>;
  const auto found = [](const std::vector<std::string>& names) { return find_series(names); };
  EXPECT_EQ(found({"bun000.ply", "bun045.ply", "chin.ply"}), (Series{{0, 1}}));
  EXPECT_EQ(found({"scan_000.xyz", "scan_001.xyz", "scan_1.ply"}), (Series{{0, 1}})) << "of one format";
  EXPECT_EQ(found({"back.ply", "front.ply", "top.ply"}), (Series{{0, 1, 2}}));
  EXPECT_EQ(found({"Bust-Back.PLY", "bust-front.ply"}), (Series{{0, 1}}));
  EXPECT_EQ(found({"kopf_hinten.ply", "kopf_vorn.ply"}), (Series{{0, 1}}));
  EXPECT_EQ(found({"back_1.ply", "back_2.ply", "front_1.ply", "front_2.ply"}), (Series{{0, 1, 2, 3}}));
  EXPECT_EQ(found({"a1.ply", "a2.ply", "b1.ply", "b2.ply"}), (Series{{0, 1}, {2, 3}}));
  EXPECT_EQ(found({"backpack.ply", "frontier.ply"}), Series{}) << "a side is a word of its own";
  EXPECT_EQ(found({"cat.ply", "dog.ply"}), Series{});
  EXPECT_EQ(found({"gear1.stl", "gear2.stl"}), Series{}) << "meshes are whole objects";
  EXPECT_EQ(found({"part1.sl1", "part2.sl1"}), Series{});
  EXPECT_EQ(found({"bun000.ply"}), Series{}) << "one file is none";
  EXPECT_EQ(series_of("2024-05-01 B\u00fcste front.ply"), "2024-05-# b\u00fcste @.ply");
}

TEST(FolderScans, AreSortedAndNoMoreThanAScanMayHave) {
  FolderScans scans;
  for (const char* name : {"b.ply", "README.txt", "a.xyz", "part.sl1", "photo.jpg"}) scans.add(name);
  EXPECT_THAT(scans.paths("bust").value(), testing::ElementsAre("bust/a.xyz", "bust/b.ply"));
  for (int i = 0; i < 31; ++i) scans.add(std::to_string(i) + ".ply");
  const auto many = scans.paths("bust");
  ASSERT_FALSE(many);
  EXPECT_THAT(many.error().message(), testing::HasSubstr("bust: the folder has 33 scans, but one scan may have 32"));
  FolderScans models;
  for (const char* name : {"readme.txt", "part.step", "b.skp"}) models.add(name);
  EXPECT_THAT(
      models.paths("cad").error().message(),
      testing::HasSubstr("cad: the folder has no scans, and b.skp is a CAD model (SketchUp): export it as STL"));
  EXPECT_THAT(FolderScans().paths("empty").error().message(), testing::HasSubstr("empty: the folder has no scans"));
}

}  // namespace
}  // namespace plumbline
