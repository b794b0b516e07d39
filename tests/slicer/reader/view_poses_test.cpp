#include "slicer/reader/view_poses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/slicer/support/admitted_cloud.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

struct File {
  std::string name, text;
};

Expected<AdmittedCloud> read(const std::vector<File>& files, Arena& arena) {
  std::vector<MemorySource> sources;
  for (const File& file : files) sources.emplace_back(file.text, file.name);
  std::vector<ByteSource*> pointers;
  for (MemorySource& source : sources) pointers.push_back(&source);
  return read_admitted(pointers, arena);
}

std::string error_of(const std::vector<File>& files) {
  ArenaBlock arena(16 * kMiB);
  const auto cloud = read(files, *arena);
  if (cloud) return "read";
  EXPECT_EQ(arena->used(), 0U);
  return cloud.error().message();
}

// Stanford's quaternions are those of the way back: this one turns x towards y, and the view is turned from y towards x.
TEST(ViewPoses, PutEachViewIntoTheCommonFrame) {
  ArenaBlock arena(16 * kMiB);
  const auto read_them =
      read({{"scans/a.xyz", "0 0 0 0 0 1\n1 0 0 1 0 0\n"},
            {"scans/b.xyz", "1 0 0 1 0 0\n0 2 0 0 0 1\n"},
            {"scans/two.CONF",
             "camera 0 0 -1  0 0 0 1\nbmesh other.ply 1 2\n\nmesh b.xyz 10 20 30 0 0 .7071067811865476 "
             ".7071067811865476\nbmesh a.xyz 0 0 0 0 0 0 2\n"}},
           *arena);
  ASSERT_TRUE(read_them.has_value()) << read_them.error().message();
  const Cloud& cloud = read_them->reading.cloud;
  ASSERT_EQ(cloud.size, 4U);
  const Vec3f origin = read_them->reading.offset.cast<float>();
  EXPECT_LT((cloud.position[1] + origin - Vec3f(1, 0, 0)).norm(), 1e-6F);
  EXPECT_LT((cloud.position[2] + origin - Vec3f(10, 19, 30)).norm(), 1e-5F);
  EXPECT_LT((cloud.position[3] + origin - Vec3f(12, 20, 30)).norm(), 1e-5F);
  EXPECT_LT((cloud.normal[2].unpack() - Vec3f(0, -1, 0)).norm(), 0.02F);
  EXPECT_EQ(read_them->reading.scans.count, 2U);
  EXPECT_EQ(cloud.views.count, 2U);
}

TEST(ViewPoses, AreRefusedUnlessEachScanHasOne) {
  const File a{"a.xyz", "0 0 0\n1 0 0\n"}, b{"b.xyz", "0 0 0\n1 0 0\n"};
  const std::string pose = " 0 0 0 0 0 0 1\n";
  const File both{"ab.conf", "bmesh a.xyz" + pose + "bmesh b.xyz" + pose};
  EXPECT_EQ(error_of({a, b, both}), "read");
  EXPECT_THAT(error_of({a, b, {"a.conf", "bmesh a.xyz" + pose}}), HasSubstr("b.xyz: a.conf does not say where"));
  EXPECT_THAT(error_of({a, {"c.conf", "bmesh c.xyz" + pose}}), HasSubstr("c.conf: it names none of the scans"));
  EXPECT_THAT(error_of({a, {"a.conf", "\nbmesh a.xyz 0 0 0 0 0 1\n"}}), HasSubstr("a.conf: line 2: expected three"));
  EXPECT_THAT(error_of({a, {"a.conf", "bmesh a.xyz 0 0 0 0 0 0 0\n"}}), HasSubstr("line 1: expected three"));
  EXPECT_THAT(error_of({a, b, both, {"a.conf", "mesh a.xyz" + pose}}), HasSubstr("a.conf: line 1: the second pose"));
  EXPECT_THAT(error_of({both}), HasSubstr("ab.conf says where scans lie"));
  EXPECT_THAT(error_of({both, a, b}), HasSubstr("ab.conf says where scans lie"));
  EXPECT_THAT(error_of({a, {"a.conf", std::string(70'000, '\n') + "bmesh a.xyz" + pose}}),
              HasSubstr("more than 65536 bytes"));
}

TEST(ViewPoses, DoNotChangeWhatIsPrinted) {
  const Surface whole = sphere(30'000, 10, {0, 0, 0});
  Surface turned(whole.begin() + 11'000, whole.end());
  for (SurfacePoint& p : turned) {  // from x towards y, and 3 up
    p.position = {-p.position[1], p.position[0], p.position[2] + 3};
    p.normal = {-p.normal[1], p.normal[0], p.normal[2]};
  }
  const std::string one = binary_ply(whole), top = binary_ply(Surface(whole.begin(), whole.begin() + 11'000));
  const std::string bottom = binary_ply(turned);
  const std::string poses = "bmesh a.ply 0 0 0 0 0 0 1\nbmesh b.ply 0 0 -3 0 0 .70710678118 .70710678118\n";
  const auto volume = [](std::vector<MemorySource> files) {
    std::vector<ByteSource*> sources;
    for (MemorySource& file : files) sources.push_back(&file);
    Slicing sliced(ScanSources(sources), settings_with_pitch(0.2F), 64 * kMiB);
    EXPECT_EQ(sliced.arena().top_used(), 0U);
    return sliced.volume();
  };
  const double expected = volume({MemorySource(one, "a.ply")});
  EXPECT_NEAR(
      volume({MemorySource(top, "a.ply"), MemorySource(bottom, "b.ply"), MemorySource(poses, "ab.conf")}) / expected, 1,
      1e-3);
}

}  // namespace
}  // namespace plumbline
