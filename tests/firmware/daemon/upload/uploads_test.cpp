/// Scans that somebody sends into the printer's store: whole ones, halves, and what is none.

#include "firmware/daemon/upload/uploads.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <array>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <thread>

#include "firmware/daemon/stick/stick_scans.hpp"
#include "firmware/daemon/upload/upload_name.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;
using Stage = UploadRecord::Stage;

constexpr std::uint64_t kMost = std::uint64_t{1} << 20U;

TEST(UploadName, IsAPlainFileNameThatEndsLikeAScan) {
  for (const char* name : {"bust.ply", "A b (2)+c_d-e.STL", "part.sl1", "9.xyz", "a..ply"}) {
    const auto checked = check_upload_name(name);
    EXPECT_TRUE(checked) << checked.error().message();
  }
  for (const std::string& name :
       {std::string(), std::string("../bust.ply"), std::string("/etc/bust.ply"), std::string("a/b.ply"),
        std::string("a\\b.ply"), std::string(".bust.ply"), std::string("-bust.ply"), std::string(" bust.ply"),
        std::string("bu\nst.ply"), std::string("bu\0st.ply", 9), std::string("b\xc3\xbcste.ply"),
        std::string("bust:1.ply"), std::string("\x1b[2Jbust.ply"), std::string(76, 'a') + ".ply"}) {
    EXPECT_EQ(check_upload_name(name).error().code(), ErrorCode::kBadSetting) << name;
  }
  for (const char* name : {"job.toml", "bust", "bust.ply.sh", "README.txt", "photo.jpg", "journal"}) {
    EXPECT_THAT(check_upload_name(name).error().message(), HasSubstr("does not have the ending of a scan")) << name;
  }
  EXPECT_THAT(check_upload_name("part.ctb").error().message(), HasSubstr("Chitubox"));
}

TEST(UploadName, CanBeMadeOfTheNameOfAnyFile) {
  for (const auto& [file, name] : {std::pair{"bust.ply", "bust.ply"},
                                   {"B\xc3\xbcste <1>.ply", "B_ste _1_.ply"},
                                   {"..-.bust.ply", "bust.ply"},
                                   {"\x1b[2J\n.ply", "__2J_.ply"},
                                   {"", ""}}) {
    EXPECT_EQ(upload_name_of(file).view(), name) << file;
  }
  EXPECT_EQ(upload_name_of(std::string(200, 'a') + ".ply").view(), std::string(75, 'a') + ".ply");
  EXPECT_EQ(upload_name_of("a." + std::string(200, 'b')).view().size(), 79U);
  EXPECT_TRUE(check_upload_name(upload_name_of(std::string(200, '\xff') + ".ply").view()));
}

class UploadsTest : public testing::Test {
 protected:
  UploadsTest() { start(); }

  /// As after a restart of the daemon.
  void start(const UploadTimes& times = {}) {
    uploads_.reset();
    record_ = std::make_unique<PrinterRecord>();
    auto store = UploadStore::open(folder_ / ".", kMost);
    ASSERT_TRUE(store) << store.error().message();
    uploads_ = std::make_unique<Uploads>(std::move(*store), *record_, times);
  }
  Expected<std::uint32_t> begin(std::string_view name, std::uint64_t bytes) {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    into_ = Descriptor(ends[0]);
    ClientRequest request;
    request.command = Command::kUpload;
    request.name.add("%.*s", static_cast<int>(name.size()), name.data());
    request.bytes = bytes;
    return uploads_->begin(request, Descriptor(ends[1]));
  }
  bool send(std::string_view text) {
    const ssize_t put = ::send(into_.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    return put == static_cast<ssize_t>(text.size());
  }
  void close() { const Descriptor gone = std::exchange(into_, Descriptor()); }
  /// A whole upload.
  bool upload(std::string_view name, std::string_view text) {
    const auto begun = begin(name, text.size());
    EXPECT_TRUE(begun) << begun.error().message();
    EXPECT_TRUE(send(text));
    close();
    return uploads_->receive();
  }
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "uploads"))
      names.insert(entry.path().filename());
    return names;
  }
  std::string problem() const { return record_->upload ? record_->upload->problem.c_str() : "none"; }

  TemporaryFolder folder_;
  std::unique_ptr<PrinterRecord> record_;
  std::unique_ptr<Uploads> uploads_;
  Descriptor into_;
};

TEST_F(UploadsTest, AreKeptWhenTheyAreWholeAndOfferedAsOnAStick) {
  EXPECT_FALSE(uploads_->port().has_stick());
  ASSERT_EQ(begin("bust.ply", 10).value(), 1U);
  EXPECT_EQ(record_->upload->stage, Stage::kComing);
  ASSERT_TRUE(send("hello"));
  EXPECT_FALSE(uploads_->receive());
  EXPECT_THAT(files(), ElementsAre(".incoming"));
  EXPECT_FALSE(uploads_->port().has_stick());
  ASSERT_TRUE(send("world"));
  EXPECT_FALSE(uploads_->receive()) << "its sender has not said that this is all";
  close();
  EXPECT_TRUE(uploads_->receive());
  EXPECT_EQ(record_->upload->stage, Stage::kKept);
  EXPECT_EQ(record_->upload->received, 10U);
  EXPECT_TRUE(record_->stored);
  EXPECT_TRUE(uploads_->take_new());
  EXPECT_FALSE(uploads_->take_new());
  EXPECT_EQ(read_text(folder_ / "uploads/bust.ply"), "helloworld");
  const auto mount = uploads_->port().mount();
  ASSERT_TRUE(mount) << mount.error().message();
  const auto scans = list_scans(*mount);
  ASSERT_TRUE(scans) << scans.error().message();
  ASSERT_EQ(scans->list.size(), 1U);
  EXPECT_THAT(scans->list[0].names, ElementsAre("bust.ply"));
  auto file = mount->open("bust.ply");
  ASSERT_TRUE(file);
  EXPECT_TRUE(file->descriptor()) << "the child reads it, not the daemon";
  std::array<std::byte, 20> bytes{};
  EXPECT_EQ(file->read(bytes).value(), 10U);
  // Another one takes its place, and who still reads this one learns that.
  EXPECT_TRUE(upload("gear.stl", "solid"));
  EXPECT_THAT(files(), ElementsAre("gear.stl"));
  EXPECT_EQ(mount->check().error().code(), ErrorCode::kStickGone);
  EXPECT_TRUE(upload("gear.stl", "solid2")) << "of the same name";
  EXPECT_EQ(read_text(folder_ / "uploads/gear.stl"), "solid2");
  EXPECT_EQ(record_->upload->number, 3U);
}

TEST_F(UploadsTest, ThatEndEarlyOrBringMoreLeaveNothingAndKeepTheOneBefore) {
  ASSERT_TRUE(upload("bust.ply", "whole"));
  ASSERT_TRUE(begin("gear.ply", 10));
  ASSERT_TRUE(send("half"));
  close();
  EXPECT_FALSE(uploads_->receive());
  EXPECT_EQ(record_->upload->stage, Stage::kFailed);
  EXPECT_THAT(problem(), HasSubstr("ended after 4 of 10 bytes. Send"));
  EXPECT_THAT(files(), ElementsAre("bust.ply"));
  ASSERT_TRUE(begin("bust.ply", 3));
  ASSERT_TRUE(send("more"));
  EXPECT_FALSE(uploads_->receive());
  EXPECT_THAT(problem(), HasSubstr("more bytes arrived"));
  EXPECT_FALSE(send("x")) << "the socket is closed";
  EXPECT_EQ(read_text(folder_ / "uploads/bust.ply"), "whole");
  EXPECT_FALSE(uploads_->is_coming());
  EXPECT_TRUE(upload("gear.ply", "next")) << "the next one may come";
}

TEST_F(UploadsTest, OfAWrongSizeAreRefusedBeforeTheyCome) {
  EXPECT_THAT(begin("bust.ply", 0).error().message(), HasSubstr("is empty"));
  EXPECT_THAT(begin("bust.ply", kMost + 1).error().message(), HasSubstr("takes 1 MiB at most"));
  EXPECT_THAT(begin("../bust.ply", 1).error().message(), HasSubstr("not a name that the"));
  EXPECT_FALSE(record_->upload);
  EXPECT_THAT(files(), IsEmpty());
  EXPECT_TRUE(begin("bust.ply", kMost));
  EXPECT_THAT(begin("gear.ply", 1).error().message(), HasSubstr("another scan is being uploaded"));
  auto large = UploadStore::open(folder_ / ".", std::uint64_t{1} << 62U);
  ASSERT_TRUE(large);
  const auto begun = large->begin("bust.ply", std::uint64_t{1} << 60U);
  EXPECT_EQ(begun.error().code(), ErrorCode::kCannotWrite);
  EXPECT_THAT(begun.error().message(), HasSubstr("MiB free"));
}

TEST_F(UploadsTest, AreTakenAtRestAndEndWhenAJobBegins) {
  for (std::size_t i = 0; i < kPrintStateCount; ++i) {
    record_->state = static_cast<PrintState>(i);
    const auto begun = begin("bust.ply", 5);
    EXPECT_EQ(begun.has_value(), at_rest(record_->state)) << to_string(record_->state);
    if (!begun) {
      EXPECT_THAT(begun.error().message(), HasSubstr("while it is at rest"));
      continue;
    }
    ASSERT_TRUE(send("hello"));
    close();
    record_->state = PrintState::kSlicing;
    EXPECT_FALSE(uploads_->receive());
    EXPECT_THAT(problem(), HasSubstr("has begun another job"));
    EXPECT_THAT(files(), IsEmpty());
  }
}

TEST_F(UploadsTest, ComeThroughALocalSocketAndNothingThatCouldWait) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  const Descriptor other(ends[1]);
  ClientRequest request;
  request.name.add("bust.ply");
  request.bytes = 5;
  std::array<Descriptor, 4> wrong{Descriptor(ends[0]), Descriptor(::open("/dev/zero", O_RDONLY | O_CLOEXEC)),
                                  Descriptor(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), Descriptor()};
  for (Descriptor& one : wrong) {
    const auto begun = uploads_->begin(request, std::exchange(one, Descriptor()));
    ASSERT_FALSE(begun);
    EXPECT_THAT(begun.error().message(), HasSubstr("no socket for the scan's bytes"));
  }
  const Descriptor lonely(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));  // never connected
  ASSERT_TRUE(uploads_->begin(request, Descriptor(::dup(lonely.get()))));
  EXPECT_FALSE(uploads_->receive());
  EXPECT_EQ(record_->upload->stage, Stage::kFailed);
}

TEST_F(UploadsTest, ThatStallAreEnded) {
  start({.silence = 20ms, .told = 0ns});
  ASSERT_TRUE(begin("bust.ply", 5));
  ASSERT_TRUE(send("he"));
  EXPECT_FALSE(uploads_->receive());
  EXPECT_TRUE(uploads_->is_coming());
  EXPECT_EQ(record_->upload->received, 2U);
  std::this_thread::sleep_for(30ms);
  EXPECT_FALSE(uploads_->receive());
  EXPECT_FALSE(uploads_->is_coming());
  EXPECT_THAT(problem(), HasSubstr("too slow: 2 of 5 bytes"));
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(UploadsTest, ThatAPowerCutEndsLeaveNothingAndTheNewestOfTwoStays) {
  ASSERT_TRUE(begin("half.ply", 10));
  ASSERT_TRUE(send("half"));
  EXPECT_FALSE(uploads_->receive());
  write_text(folder_ / "uploads/old.ply", "old");
  const std::array<timespec, 2> then{timespec{1, 0}, timespec{1, 0}};
  ASSERT_EQ(::utimensat(AT_FDCWD, (folder_ / "uploads/old.ply").c_str(), then.data(), 0), 0);
  write_text(folder_ / "uploads/new.ply", "new");
  std::filesystem::create_symlink("/etc/passwd", folder_ / "uploads/link.ply");
  EXPECT_THAT(files(), UnorderedElementsAre(".incoming", "old.ply", "new.ply", "link.ply"));
  uploads_.reset();
  start();
  EXPECT_THAT(files(), ElementsAre("new.ply"));
  EXPECT_TRUE(record_->stored);
  EXPECT_FALSE(uploads_->is_new()) << "it is offered when somebody asks";
  EXPECT_TRUE(uploads_->port().has_stick());
  EXPECT_TRUE(upload("next.ply", "next"));
  EXPECT_THAT(files(), ElementsAre("next.ply"));
}

TEST_F(UploadsTest, AreRemovedByTheNameThatIsShown) {
  EXPECT_THAT(uploads_->remove("bust.ply").error().message(), HasSubstr("no scan in the printer's store"));
  ASSERT_TRUE(upload("bust.ply", "hello"));
  ASSERT_TRUE(record_->stored);
  EXPECT_EQ(record_->stored->name.view(), "bust.ply");
  EXPECT_EQ(record_->stored->bytes, 5U);
  write_text(folder_ / "journal", "precious");
  for (const char* name : {"", ".", "..", "bust", "Bust.ply", "gear.ply", "../journal", "../uploads/bust.ply",
                           "bust.ply/", ".incoming", "bust.ply\n"}) {
    const auto removed = uploads_->remove(name);
    ASSERT_FALSE(removed) << name;
    EXPECT_EQ(removed.error().code(), ErrorCode::kBadSetting);
    EXPECT_THAT(removed.error().message(), HasSubstr("The scan there is bust.ply"));
  }
  EXPECT_THAT(files(), ElementsAre("bust.ply"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "journal"));
  {
    const auto mount = uploads_->port().mount();
    ASSERT_TRUE(mount);
    ASSERT_TRUE(uploads_->remove("bust.ply"));
    EXPECT_EQ(mount->check().error().code(), ErrorCode::kNoStick);
  }
  EXPECT_THAT(files(), IsEmpty());
  EXPECT_FALSE(record_->stored);
  EXPECT_FALSE(uploads_->port().has_stick());
  EXPECT_FALSE(uploads_->is_new()) << "nothing is left to offer";
  uploads_.reset();
  start();
  EXPECT_FALSE(record_->stored);
  // Beside one that comes, and then that one.
  ASSERT_TRUE(upload("old.ply", "old"));
  ASSERT_TRUE(begin("new.ply", 10));
  ASSERT_TRUE(send("hello"));
  EXPECT_FALSE(uploads_->receive());
  ASSERT_TRUE(uploads_->remove("old.ply"));
  EXPECT_THAT(files(), ElementsAre(".incoming"));
  ASSERT_TRUE(send("world"));
  close();
  EXPECT_TRUE(uploads_->receive());
  EXPECT_THAT(files(), ElementsAre("new.ply"));
  ASSERT_TRUE(uploads_->remove("new.ply"));
  // One that people have put there, whose name does not fit the record.
  uploads_.reset();
  write_text(folder_ / ("uploads/" + std::string(200, 'n') + "\x1b.ply"), "x");
  start();
  const std::string shown(record_->stored->name.view());
  EXPECT_EQ(shown.size(), 79U);
  EXPECT_TRUE(uploads_->remove(shown));
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(UploadsTest, TakeALargeOneInTurns) {
  const std::string text(kMost, 'x');
  ASSERT_TRUE(begin("bust.ply", kMost));
  std::size_t sent = 0, turns = 0;
  bool whole = false;
  for (; !whole && turns < 100'000; ++turns) {
    const ssize_t put = into_.is_open() ? ::send(into_.get(), text.data() + sent, text.size() - sent, MSG_DONTWAIT) : 0;
    if (put > 0) sent += static_cast<std::size_t>(put);
    if (sent == text.size()) close();
    whole = uploads_->receive();
  }
  EXPECT_TRUE(whole) << problem();
  EXPECT_GT(turns, 2U) << "the socket does not hold all of it";
  EXPECT_EQ(std::filesystem::file_size(folder_ / "uploads/bust.ply"), kMost);
}

}  // namespace
}  // namespace plumbline::firmware
