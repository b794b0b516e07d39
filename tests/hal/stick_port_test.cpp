/// Contract of every back end: the port for sticks.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include "tests/hal/contract.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

class StickContract : public Contract {
 protected:
  void SetUp() override {
    Contract::SetUp();
    folder_ = std::filesystem::path(testing::TempDir()) / ("stick-" + std::to_string(::getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_ / "scans");
    write("bust.ply", std::string(300'000, 'p'));
    write("job.toml", "[job]\n");
    write(".hidden", "x");
    write("scans/arm.xyz", "1 2 3\n");
    std::filesystem::create_symlink("/etc/passwd", folder_ / "link.ply");
    std::filesystem::create_directory_symlink("/etc", folder_ / "etc");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const char* name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  void plug() {
    rig_->plug_stick(folder_.string(), 0ns);
    ASSERT_THAT(events_in(2s), testing::ElementsAre(EventKind::kStickArrived));
  }
  std::filesystem::path folder_;
};

TEST_P(StickContract, ReportsGoIntoTheirFolderAndOverwriteNothing) {
  StickPort& port = rig_->machine().stick;
  const int file = ::open((folder_ / "bust.ply").c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(file, 0);
  const StickReport report{"sim2k-20261127-0001.json", file, 5, 200'000};
  EXPECT_TRUE(failed_with(port.store(report), ErrorCode::kNoStick));
  plug();
  EXPECT_TRUE(failed_with(port.store(report), ErrorCode::kCannotWrite)) << "the stick has not asked for it";
  const auto folder = folder_ / "plumbline-reports";
  std::filesystem::create_directory_symlink(folder_ / "scans", folder);
  EXPECT_TRUE(failed_with(port.store(report), ErrorCode::kCannotWrite)) << "a link may lead anywhere";
  std::filesystem::remove(folder);
  std::filesystem::create_directory(folder);
  write("plumbline-reports/unfinished", "of a print whose stick was pulled");
  {
    const auto mount = port.mount();
    ASSERT_TRUE(mount);
    EXPECT_TRUE(failed_with(port.store(report), ErrorCode::kBusy));
  }
  EXPECT_EQ(port.store(report).value(), true);
  EXPECT_EQ(port.store(report).value(), false) << "it is there";
  std::ifstream stored(folder / report.name, std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stored), {}), std::string(200'000, 'p'));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  std::filesystem::create_symlink(folder_ / "job.toml", folder / "linked.json");
  EXPECT_EQ(port.store({"linked.json", file, 0, 10}).value(), false) << "nothing is written through a link";
  for (const char* name : {"", ".hidden", "../job.toml", "a/b", "a b"}) {
    EXPECT_TRUE(failed_with(port.store({name, file, 0, 10}), ErrorCode::kCannotWrite)) << name;
  }
  EXPECT_TRUE(failed_with(port.store({"short.json", file, 299'999, 10}), ErrorCode::kCannotWrite));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2) << "nothing is left of what failed";
  ::close(file);
}

TEST_P(StickContract, StickArrivesIsMountedIsReadAndLeaves) {
  StickPort& port = rig_->machine().stick;
  EXPECT_FALSE(port.has_stick());
  EXPECT_TRUE(failed_with(port.identity(), ErrorCode::kNoStick));
  EXPECT_TRUE(failed_with(port.mount(), ErrorCode::kNoStick));
  plug();
  EXPECT_TRUE(port.has_stick());
  EXPECT_NE(port.identity().value().vendor_id, 0);
  {
    const auto mount = port.mount();
    ASSERT_TRUE(mount) << mount.error().message();
    EXPECT_TRUE(failed_with(port.mount(), ErrorCode::kBusy));
    auto file = mount->open("job.toml");
    ASSERT_TRUE(file) << file.error().message();
    EXPECT_EQ(file->name(), "job.toml");
    EXPECT_EQ(file->size(), 6U);
    std::array<std::byte, 100> buffer{};
    EXPECT_EQ(file->read(buffer).value(), 6U);
    EXPECT_EQ(file->read(buffer).value(), 0U);
    EXPECT_TRUE(mount->open("scans/arm.xyz"));
    EXPECT_TRUE(mount->open("./scans//arm.xyz"));
  }
  EXPECT_TRUE(port.mount());
  rig_->pull_stick(0ns);
  EXPECT_THAT(events_in(2s), testing::ElementsAre(EventKind::kStickDeparted));
  EXPECT_FALSE(port.has_stick());
}

TEST_P(StickContract, ListsFilesAndNamesWhatIsNone) {
  ASSERT_EQ(::mkfifo((folder_ / "job.ply").c_str(), 0600), 0);
  plug();
  struct Names final : StickMount::FileVisitor {
    void on_file(std::string_view name, const StickFileFacts& facts) override {
      sizes[path_on_stick({}, name, facts.partition)] = facts.bytes;
    }
    void on_other(std::string_view name, const char* what) override { others[std::string(name)] = what; }
    std::map<std::string, std::uint64_t> sizes;
    std::map<std::string, std::string> others;
  } names;
  const auto mount = rig_->machine().stick.mount();
  ASSERT_TRUE(mount);
  ASSERT_TRUE(mount->for_each_file(names));
  ASSERT_TRUE(mount->for_each_file(names)) << "also a second time";
  EXPECT_THAT(names.sizes, testing::ElementsAre(testing::Pair("bust.ply", 300'000), testing::Pair("job.toml", 6)));
  EXPECT_THAT(names.others,
              testing::ElementsAre(testing::Pair("etc", "a symbolic link"), testing::Pair("job.ply", "a pipe"),
                                   testing::Pair("link.ply", "a symbolic link"), testing::Pair("scans", "a folder")));
  EXPECT_TRUE(failed_with(mount->open("job.ply"), ErrorCode::kCannotOpen)) << "and does not wait for a writer";
}

TEST_P(StickContract, SeesAllPartitionsAsOneAndTellsFilesOfOneNameApart) {
  const auto part = [this](int number) {
    return std::filesystem::path(folder_.string() + "." + std::to_string(number));
  };
  std::filesystem::create_directories(part(2) / "scans");
  std::filesystem::create_directories(part(3) / "bust.ply");
  const auto put = [](const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  };
  put(part(2) / "bust.ply", "second");
  put(part(2) / "leg.ply", "a leg");
  put(part(2) / "scans/arm.xyz", "4 5 6 7\n");
  put(part(2) / "scans/hand.xyz", "1\n");
  put(part(3) / "job.toml", "[another]\n");
  plug();
  struct Names final : StickMount::FileVisitor {
    void on_file(std::string_view name, const StickFileFacts& facts) override {
      sizes[path_on_stick(folder, name, facts.partition)] = facts.bytes;
    }
    void on_other(std::string_view /*name*/, const char* /*what*/) override {}
    void on_folder(std::string_view name) override { folders.insert(std::string(name)); }
    std::string folder;
    std::map<std::string, std::uint64_t> sizes;
    std::multiset<std::string> folders;
  } top, scans;
  {
    const auto mount = rig_->machine().stick.mount();
    ASSERT_TRUE(mount);
    using testing::Pair;
    ASSERT_TRUE(mount->for_each_file(top));
    EXPECT_THAT(top.sizes, testing::ElementsAre(Pair("2:bust.ply", 6), Pair("3:job.toml", 10),
                                                Pair("bust.ply", 300'000), Pair("job.toml", 6), Pair("leg.ply", 5)));
    EXPECT_THAT(top.folders, testing::ElementsAre("bust.ply", "scans", "scans"));
    scans.folder = "scans";
    ASSERT_TRUE(mount->for_each_file(scans, "scans"));
    EXPECT_THAT(scans.sizes,
                testing::ElementsAre(Pair("2:scans/arm.xyz", 8), Pair("scans/arm.xyz", 6), Pair("scans/hand.xyz", 2)));
    EXPECT_EQ(mount->open("bust.ply").value().size(), 300'000U);
    EXPECT_EQ(mount->open("2:bust.ply").value().size(), 6U);
    EXPECT_EQ(mount->open("scans/hand.xyz").value().size(), 2U);
    EXPECT_EQ(mount->open("2:scans/arm.xyz").value().size(), 8U);
    EXPECT_TRUE(mount->is_folder("3:bust.ply"));
    for (const char* name : {"2:none.ply", "4:bust.ply", "0:bust.ply", "2:", "2:../x", "2:/etc/passwd", "none.ply"}) {
      EXPECT_TRUE(failed_with(mount->open(name), ErrorCode::kCannotOpen)) << name;
    }
    EXPECT_EQ(mount->name_beside("scans/hand.xyz", "bust.ply"), "2:bust.ply") << "its own partition's";
    EXPECT_EQ(mount->name_beside("job.toml", "bust.ply"), "bust.ply");
    EXPECT_EQ(mount->name_beside("3:job.toml", "leg.ply"), "leg.ply") << "it has none";
  }
  // The reports go where their folder is.
  std::filesystem::create_directory(part(2) / "plumbline-reports");
  const int file = ::open((part(2) / "leg.ply").c_str(), O_RDONLY | O_CLOEXEC);
  EXPECT_EQ(rig_->machine().stick.store({"a.json", file, 0, 5}).value(), true);
  ::close(file);
  EXPECT_TRUE(std::filesystem::exists(part(2) / "plumbline-reports/a.json"));
  for (const int number : {2, 3}) std::filesystem::remove_all(part(number));
}

TEST_P(StickContract, EndsAListingWhenItsVisitorWantsNoMore) {
  plug();
  struct Impatient final : StickMount::FileVisitor {
    void on_file(std::string_view /*name*/, const StickFileFacts& /*facts*/) override { ++visited; }
    void on_other(std::string_view /*name*/, const char* /*what*/) override { ++visited; }
    Expected<bool> goes_on() override {
      if (fails) return fail(ErrorCode::kCancelled, "cancelled");
      return visited < 2;
    }
    int visited = 0;
    bool fails = false;
  } visitor;
  const auto mount = rig_->machine().stick.mount();
  ASSERT_TRUE(mount);
  EXPECT_TRUE(mount->for_each_file(visitor));
  EXPECT_EQ(visitor.visited, 2);
  visitor.fails = true;
  EXPECT_TRUE(failed_with(mount->for_each_file(visitor), ErrorCode::kCancelled));
  EXPECT_EQ(visitor.visited, 2);
}

TEST_P(StickContract, OpensAFileOf4GiB) {
  // A sparse file, which takes no space. FAT32 allows one byte less.
  constexpr std::uint64_t kBytes = std::uint64_t{4} << 30U;
  std::ofstream(folder_ / "large.ply") << "ply";
  std::filesystem::resize_file(folder_ / "large.ply", kBytes);
  plug();
  const auto mount = rig_->machine().stick.mount();
  ASSERT_TRUE(mount);
  auto file = mount->open("large.ply");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->size(), kBytes);
  std::array<std::byte, 3> buffer{};
  EXPECT_EQ(file->read(buffer).value(), 3U);
}

TEST_P(StickContract, OpensNothingOutsideItsMount) {
  plug();
  const auto mount = rig_->machine().stick.mount();
  ASSERT_TRUE(mount);
  for (const char* name : {"", "/etc/passwd", "../x", "scans/../../x", "..", "link.ply", "etc/passwd", "scans",
                           "none.ply", "scans/arm.xyz/", "."}) {
    EXPECT_TRUE(failed_with(mount->open(name), ErrorCode::kCannotOpen)) << name;
  }
  EXPECT_TRUE(failed_with(mount->open(std::string(5000, 'a')), ErrorCode::kCannotOpen));
  EXPECT_TRUE(failed_with(mount->open(std::string_view("job.toml\0x", 10)), ErrorCode::kCannotOpen));
}

TEST_P(StickContract, ReportsAPullDuringAReadAndReadsTheNextStick) {
  plug();
  {
    const auto mount = rig_->machine().stick.mount();
    ASSERT_TRUE(mount);
    auto file = mount->open("bust.ply");
    ASSERT_TRUE(file);
    std::array<std::byte, 1000> buffer{};
    ASSERT_TRUE(file->read(buffer));
    rig_->pull_stick(0ns);
    EXPECT_THAT(events_in(1s), testing::ElementsAre(EventKind::kStickDeparted));
    EXPECT_TRUE(failed_with(file->read(buffer), ErrorCode::kStickGone));
    rig_->plug_stick(folder_.string(), 0ns);
    EXPECT_THAT(events_in(1s), testing::ElementsAre(EventKind::kStickArrived));
    EXPECT_TRUE(failed_with(file->read(buffer), ErrorCode::kStickGone))
        << "files opened before the pull stay unreadable";
  }
  const auto mount = rig_->machine().stick.mount();
  ASSERT_TRUE(mount);
  EXPECT_TRUE(mount->open("bust.ply"));
}

INSTANTIATE_TEST_SUITE_P(Hal, StickContract, testing::ValuesIn(rig_makers()), kRigName);

}  // namespace
}  // namespace plumbline
