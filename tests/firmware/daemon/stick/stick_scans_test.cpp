/// What of a stick is offered.

#include "firmware/daemon/stick/stick_scans.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "firmware/daemon/stick/scan_series.hpp"
#include "firmware/io/scan_names.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

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

struct StickPower {
  Interlock interlock;
};

/// Folders in the place of a stick's partitions.
class FoldersPort final : private StickPower, public StickPort {
 public:
  explicit FoldersPort(std::vector<std::string> folders) : StickPort(interlock), folders_(std::move(folders)) {}
  std::size_t unread = 0;
  bool pulled = false;

 private:
  bool do_has_stick() const override { return true; }
  Expected<StickIdentity> do_identity() const override { return StickIdentity{}; }
  Expected<StickParts> do_mount() override {
    StickParts parts;
    for (const std::string& folder : folders_) {
      parts.folders[parts.count++] = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    }
    parts.unread = unread;
    return parts;
  }
  Expected<bool> do_store(const StickReport& /*report*/) override { return not_stored(EROFS); }
  Expected<std::size_t> do_read(int /*file*/, std::span<std::byte> /*buffer*/) override { return 0; }
  Status do_check_mounted() const override {
    if (pulled) return fail(ErrorCode::kStickGone, "pulled");
    return {};
  }
  bool do_has_real_files() const override { return true; }

  std::vector<std::string> folders_;
};

class StickList : public testing::Test {
 protected:
  StickList() {
    for (const char* part : {"1", "2"}) std::filesystem::create_directory(stick_ / part);
  }
  /// @param age  s; a larger one is older
  void put(const std::string& path, int age = 0, const char* part = "1") {
    const std::filesystem::path file = std::filesystem::path(stick_ / part) / path;
    std::filesystem::create_directories(file.parent_path());
    write_text(file, "x");
    const std::array<timespec, 2> then{timespec{1'700'000'000 - age, 0}, timespec{1'700'000'000 - age, 0}};
    ASSERT_EQ(::utimensat(AT_FDCWD, file.c_str(), then.data(), 0), 0);
  }
  Expected<StickScans> list(std::string_view folder = {}, const ListingLimits& limits = {}) {
    const auto mount = port_.mount();
    return list_scans(*mount, folder, look_, limits);
  }
  /// The first name of each entry; how many a series has stands behind it.
  static std::vector<std::string> names(const Expected<StickScans>& scans) {
    std::vector<std::string> names;
    if (!scans) return {scans.error().message()};
    for (const StickEntry& entry : scans->list) {
      const std::size_t files = entry.names.size();
      names.push_back(entry.names[0] + (files > 1 ? " of " + std::to_string(files) : ""));
    }
    return names;
  }
  static std::map<std::string, std::size_t> folders(const Expected<StickScans>& scans) {
    std::map<std::string, std::size_t> folders;
    for (const StickFolder& folder : scans->folders) folders[folder.name] = folder.entries;
    return folders;
  }

  TemporaryFolder stick_;
  FoldersPort port_{{stick_ / "1", stick_ / "2"}};
  std::function<Status()> look_ = [] { return Status(); };
};

TEST_F(StickList, HasTheNewestFirstFromAnyDepthAndAmongEqualsTheFirstByName) {
  put("old.ply", 500);
  put("b.stl", 20);
  put("a.stl", 20);
  put("deep/a/b/c/d/e/f/g/new.sl1");
  put("deep/middle.3mf", 60);
  put("deep/README.txt");
  const auto scans = list();
  EXPECT_THAT(names(scans), ElementsAre("deep/a/b/c/d/e/f/g/new.sl1", "a.stl", "b.stl", "deep/middle.3mf", "old.ply"));
  EXPECT_THAT(folders(scans), ElementsAre(Pair("deep", 2)));
  EXPECT_EQ(scans->left_out + scans->folders_left_out, 0U);
}

TEST_F(StickList, OffersTheOnlyOneWhereverItLies) {
  put("a/b/c/only.ply");
  EXPECT_THAT(names(list()), ElementsAre("a/b/c/only.ply"));
  std::filesystem::remove_all(stick_ / "1/a");
  put("prints/2024/chitubox.zip");
  put("prints/points.txt", 5);
  EXPECT_THAT(names(list()), ElementsAre("prints/2024/chitubox.zip", "prints/points.txt")) << "there is nothing else";
  put("bust.ply", 100);
  EXPECT_THAT(names(list()), ElementsAre("bust.ply")) << "most files of these kinds are something else";
  EXPECT_THAT(folders(list()), ElementsAre(Pair("prints", 2))) << "but they can be found";
  EXPECT_THAT(names(list("prints")), ElementsAre("prints/points.txt"));
  EXPECT_THAT(names(list("prints/2024")), ElementsAre("prints/2024/chitubox.zip"));
}

TEST_F(StickList, OfManyHasTheFoldersOwnAndFoldersToOpen) {
  for (int i = 0; i < 30; ++i) put("many/part" + std::to_string(i) + ".stl", 100 + i);
  for (int i = 0; i < 10; ++i) put("B/in/part" + std::to_string(i) + ".stl", 200 + i);
  put("a/bust.ply", 10);
  put("top.ply", 1000);
  const auto scans = list();
  ASSERT_TRUE(scans);
  EXPECT_EQ(scans->list.size(), StickScans::kMostWithFolders);
  EXPECT_THAT(names(scans), testing::Contains("a/bust.ply"));
  EXPECT_THAT(names(scans), testing::Contains("top.ply")) << "the folder's own, however old";
  std::vector<std::string> order;
  for (const StickFolder& folder : scans->folders) order.push_back(folder.name);
  EXPECT_THAT(order, ElementsAre("a", "B", "many"));
  EXPECT_THAT(folders(scans), UnorderedElementsAre(Pair("a", 1), Pair("B", 10), Pair("many", 30)));
  EXPECT_EQ(scans->left_out, 0U) << "the others can be opened";
  const auto many = list("many");
  EXPECT_EQ(many->list.size(), 30U);
  EXPECT_EQ(many->list[0].names[0], "many/part0.stl");
  EXPECT_EQ(many->name_within("many/part0.stl"), "part0.stl");
  EXPECT_EQ(many->name_within("2:many/part0.stl"), "2:part0.stl");
  EXPECT_THAT(folders(list("B")), ElementsAre(Pair("B/in", 10)));
  EXPECT_EQ(parent_of("B/in"), "B");
  EXPECT_EQ(parent_of("B"), "");
}

TEST_F(StickList, OffersASeriesBehindItsFiles) {
  for (const char* name : {"back.ply", "front.ply", "turn/1.ply", "turn/2.ply", "turn/cat.ply"}) put(name, 10);
  put("new.ply");
  EXPECT_THAT(names(list()),
              ElementsAre("new.ply", "back.ply", "front.ply", "turn/cat.ply", "back.ply of 2", "turn/1.ply of 2"));
  EXPECT_THAT(names(list("turn")), ElementsAre("turn/1.ply", "turn/2.ply", "turn/cat.ply", "turn/1.ply of 2"))
      << "in an opened folder also singly";
}

TEST_F(StickList, CountsWhatIsBeyondItsLimits) {
  for (int i = 0; i < 70; ++i) put("part" + std::to_string(i) + ".stl", i);
  auto scans = list();
  EXPECT_EQ(scans->list.size(), StickScans::kMost);
  EXPECT_EQ(scans->list[63].names[0], "part63.stl");
  EXPECT_EQ(scans->left_out, 6U);
  put("1/2/3/4/5/6/7/8/eight.ply");
  put("1/2/3/4/5/6/7/8/9/nine.ply");
  put("1/2/3/4/5/6/7/8/nine/nine.ply");
  scans = list();
  EXPECT_EQ(folders(scans).at("1"), 1U);
  EXPECT_EQ(scans->folders_left_out, 2U);
  EXPECT_THAT(names(list("1/2/3/4/5/6/7/8")), ElementsAre("1/2/3/4/5/6/7/8/eight.ply"));
  EXPECT_EQ(list("1/2/3/4/5/6/7/8")->folders_left_out, 2U);
  for (int i = 0; i < 70; ++i) put("some/" + std::to_string(i) + "/a.ply");
  scans = list("some");
  EXPECT_EQ(scans->folders.size(), StickScans::kMostFolders);
  EXPECT_EQ(scans->folders_left_out, 38U);
  scans = list("some", {.folders = 10});
  EXPECT_EQ(scans->folders.size(), 10U);
  EXPECT_EQ(scans->folders_left_out, 60U);
  const std::string longest(200, 'n');
  put(longest + "/" + longest + ".ply");
  EXPECT_EQ(list()->left_out, 7U) << "no request has room for its path";
  port_.unread = 3;
  EXPECT_EQ(list()->partitions_left_out, 3U);
}

TEST_F(StickList, EndsOnAFullStickAndTellsHowMuchItHasNotSeen) {
  for (int i = 0; i < 300; ++i) put("full/" + std::to_string(i) + ".stl");
  put("other/a.stl");
  auto scans = list("full", {.entries = 50});
  EXPECT_EQ(scans->list.size(), 50U);
  EXPECT_EQ(scans->left_out, 250U) << "their names are counted";
  scans = list({}, {.facts = std::chrono::milliseconds(0)});
  EXPECT_TRUE(scans->list.empty());
  EXPECT_THAT(folders(scans), ElementsAre(Pair("full", 300), Pair("other", 1)));
  scans = list({}, {.names = std::chrono::milliseconds(0)});
  EXPECT_TRUE(scans->list.empty());
  EXPECT_EQ(scans->folders_left_out, 1U) << "the top folder itself";
}

TEST_F(StickList, EndsWhenSomebodyWantsThatOrPullsTheStick) {
  for (int i = 0; i < 30; ++i) put("full/" + std::to_string(i) + ".stl");
  int looks = 0;
  look_ = [&looks] { return ++looks < 5 ? Status() : Status(fail(ErrorCode::kCancelled, "cancelled")); };
  EXPECT_TRUE(list("full", {.look = std::chrono::hours(1)}));
  EXPECT_EQ(looks, 0);
  EXPECT_EQ(list("full", {.look = std::chrono::milliseconds(0)}).error().code(), ErrorCode::kCancelled);
  EXPECT_EQ(looks, 5) << "it ends at once";
  look_ = [] { return Status(); };
  port_.pulled = true;
  const auto mount = port_.mount();
  EXPECT_EQ(list_scans(*mount).error().code(), ErrorCode::kStickGone);
}

TEST_F(StickList, FollowsNoLinkAndPassesOverWhatComputersMake) {
  put("bust.ply");
  for (const char* path : {"System Volume Information/a.ply", "x/$RECYCLE.BIN/a.ply", ".Trashes/a.ply", "x/._a.ply"})
    put(path);
  std::filesystem::create_directory_symlink(".", stick_ / "1/loop");
  std::filesystem::create_directory_symlink("/etc", stick_ / "1/x/etc");
  std::filesystem::create_symlink("/etc/passwd", stick_ / "1/x/passwd.ply");
  EXPECT_THAT(names(list()), ElementsAre("bust.ply"));
  EXPECT_THAT(folders(list()), testing::IsEmpty());
  EXPECT_EQ(list("loop").error().code(), ErrorCode::kCannotRead);
}

TEST_F(StickList, HasAllPartitions) {
  put("EFI/BOOT/bootx64.efi");
  put("bust.ply", 5, "2");
  put("scans/a.ply", 10, "2");
  EXPECT_THAT(names(list()), ElementsAre("bust.ply", "scans/a.ply")) << "the first one is a Mac's EFI partition";
  put("bust.ply", 7);
  put("scans/a.ply", 3);
  put("scans/b.ply", 4);
  EXPECT_THAT(names(list()), ElementsAre("scans/a.ply", "scans/b.ply", "2:bust.ply", "bust.ply", "2:scans/a.ply"));
  EXPECT_THAT(names(list("scans")), ElementsAre("scans/a.ply", "scans/b.ply", "2:scans/a.ply"));
  put("job.toml", 0, "2");
  EXPECT_EQ(list()->job_file.view(), "job.toml");
  put("job.toml");
  EXPECT_THAT(names(list()), ElementsAre(HasSubstr("job.toml and 2:job.toml: the stick has two jobs")));
}

}  // namespace
}  // namespace plumbline::firmware
