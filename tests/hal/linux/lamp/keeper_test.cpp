/// The keeper with real processes: however the firmware dies, the lamp goes off.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <optional>
#include <random>
#include <string>
#include <thread>

#include "tests/hal/linux/lamp/keeper_line.hpp"

namespace plumbline {
namespace {

/// A process that lights the lamp repeatedly, as the firmware does.
pid_t firmware(const Line& line, nanoseconds cure) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  auto keeper = LampKeeper::start(line.settings());
  if (!keeper) ::_exit(3);
  for (;;) {
    if (!keeper->light(cure)) ::_exit(4);
    while (!keeper->went_dark()) ::usleep(200);
  }
}

TEST(Keeper, LightsForExactlyTheRequestedTime) {
  const Line line;
  auto keeper = LampKeeper::start(line.settings());
  ASSERT_TRUE(keeper) << keeper.error().message();
  EXPECT_TRUE(line.changes().empty());
  const auto lit = keeper->light(50ms);
  ASSERT_TRUE(lit) << lit.error().message();
  const auto changes = line.wait_for(2);
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_TRUE(changes[0].lit);
  EXPECT_FALSE(changes[1].lit);
  EXPECT_GE(changes[1].at - changes[0].at, 49ms);
  EXPECT_LE(changes[1].at - changes[0].at, 80ms) << "with tolerance for a busy machine";
  EXPECT_TRUE(keeper->went_dark());
}

TEST(Keeper, TurnsOffOnRequest) {
  const Line line;
  auto keeper = LampKeeper::start(line.settings());
  ASSERT_TRUE(keeper);
  ASSERT_TRUE(keeper->light(10s));
  const auto dark = keeper->turn_off();
  ASSERT_TRUE(dark);
  const auto changes = line.changes();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_LE(changes[1].at, *dark);
  EXPECT_TRUE(keeper->turn_off()) << "also if it is off";
  EXPECT_EQ(line.changes().size(), 2U);
}

TEST(Keeper, RefusesASecondAZeroAndAnEndlessExposure) {
  const Line line;
  auto keeper = LampKeeper::start(line.settings());
  ASSERT_TRUE(keeper);
  EXPECT_EQ(keeper->light(0ns).error().code(), ErrorCode::kExposureTooLong);
  EXPECT_EQ(keeper->light(301s).error().code(), ErrorCode::kExposureTooLong);
  EXPECT_TRUE(line.changes().empty());
  ASSERT_TRUE(keeper->light(10s));
  EXPECT_EQ(keeper->light(10s).error().code(), ErrorCode::kLampFailed);
  EXPECT_FALSE(line.wait_for(2).back().lit) << "a refused exposure is off";
}

TEST(Keeper, TurnsOffWhenItsObjectIsDestroyed) {
  const Line line;
  {
    auto keeper = LampKeeper::start(line.settings());
    ASSERT_TRUE(keeper);
    ASSERT_TRUE(keeper->light(10s));
  }
  const auto changes = line.changes();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_FALSE(changes.back().lit);
}

TEST(Keeper, TurnsOffOnSigtermAndTheFirmwareCannotLightAgain) {
  const Line line;
  auto keeper = LampKeeper::start(line.settings());
  ASSERT_TRUE(keeper);
  ASSERT_TRUE(keeper->light(10s));
  ASSERT_EQ(::kill(keeper->process(), SIGTERM), 0);
  EXPECT_FALSE(line.wait_for(2).back().lit);
  EXPECT_EQ(keeper->light(1s).error().code(), ErrorCode::kLampFailed);
}

TEST(Keeper, MeetsItsDeadlineWhenTheMainLoopHangs) {
  const Line line;
  const pid_t child = ::fork();
  if (child == 0) {
    auto keeper = LampKeeper::start(line.settings());
    if (!keeper || !keeper->light(300ms)) ::_exit(3);
    for (;;) ::pause();
  }
  const auto changes = line.wait_for(2);
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_NEAR(static_cast<double>((changes[1].at - changes[0].at).count()), 300e6, 50e6);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

TEST(Keeper, TurnsOffWithin50MsWheneverTheFirmwareIsKilled) {
  std::mt19937 random(20240607);
  nanoseconds slowest{};
  for (int round = 0; round < 20; ++round) {
    const Line line;
    const pid_t child = firmware(line, 2s);
    const auto lit = line.wait_for(1);
    ASSERT_EQ(lit.size(), 1U) << "round " << round;
    ::usleep(std::uniform_int_distribution<useconds_t>(0, 150'000)(random));
    const auto killed = monotonic_now();
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    const auto changes = line.wait_for(2);
    ::waitpid(child, nullptr, 0);
    ASSERT_EQ(changes.size(), 2U) << "round " << round << ": the lamp is still lit";
    ASSERT_FALSE(changes[1].lit);
    ASSERT_GE(changes[1].at, killed) << "the kill should hit an exposure";
    slowest = std::max(slowest, changes[1].at - killed);
    EXPECT_LE(changes[1].at - killed, 50ms) << "round " << round;
  }
  RecordProperty("slowest_us", static_cast<int>(slowest.count() / 1000));
  std::printf("slowest of 20: dark %.2f ms after kill -9\n", static_cast<double>(slowest.count()) / 1e6);
}

/// A cover switch: a FIFO beside the line.
class Cover {
 public:
  explicit Cover(const Line& line) : path_(line.folder() + "/cover") { EXPECT_EQ(::mkfifo(path_.c_str(), 0600), 0); }
  std::string option() const { return "file:" + path_; }
  std::ofstream opened() const { return std::ofstream(path_); }
  void say(const char* words) const { opened() << words << std::flush; }

 private:
  std::string path_;
};

LampKeeper::Settings with_cover(const Line& line, const Cover& cover) {
  LampKeeper::Settings settings = line.settings();
  settings.cover = cover.option();
  return settings;
}

/// The keeper's next notice, waiting at most 1 s.
std::optional<LampKeeper::Notice> next_notice_of(LampKeeper& keeper) {
  const auto until = monotonic_now() + 1s;
  auto notice = keeper.next_notice();
  while (!notice && monotonic_now() < until) {
    ::usleep(500);
    notice = keeper.next_notice();
  }
  return notice;
}

TEST(Keeper, TurnsOffWhenTheCoverOpensAndReportsTheReasonFirst) {
  using Kind = LampKeeper::Notice::Kind;
  const Line line;
  const Cover cover(line);
  auto keeper = LampKeeper::start(with_cover(line, cover));
  ASSERT_TRUE(keeper) << keeper.error().message();
  EXPECT_EQ(next_notice_of(*keeper)->kind, Kind::kCoverClosed) << "the state at the start";
  ASSERT_TRUE(keeper->light(10s));
  cover.say("o");
  const auto opened = next_notice_of(*keeper);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->kind, Kind::kCoverOpened);
  const auto dark = next_notice_of(*keeper);
  ASSERT_TRUE(dark);
  EXPECT_EQ(dark->kind, Kind::kDark);
  const auto changes = line.changes();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_LE(changes[1].at - opened->at, 10ms);
  EXPECT_EQ(keeper->light(1s).error().code(), ErrorCode::kLampFailed) << "not with the cover open";
  EXPECT_EQ(line.changes().size(), 2U);
  cover.say("cococ");
  const auto closed = next_notice_of(*keeper);
  ASSERT_TRUE(closed);
  EXPECT_EQ(closed->kind, Kind::kCoverClosed) << "once, when the contact has settled";
  EXPECT_FALSE(keeper->next_notice());
  EXPECT_TRUE(keeper->light(1s));
}

TEST(Keeper, TurnsOffWhenTheCoverOpensWhileTheMainLoopHangs) {
  const Line line;
  const Cover cover(line);
  const pid_t child = ::fork();
  if (child == 0) {
    auto keeper = LampKeeper::start(with_cover(line, cover));
    if (!keeper || !keeper->light(10s)) ::_exit(3);
    for (;;) ::pause();
  }
  ASSERT_EQ(line.wait_for(1).size(), 1U);
  const auto opened = monotonic_now();
  cover.say("o");
  const auto changes = line.wait_for(2);
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_FALSE(changes[1].lit);
  EXPECT_LE(changes[1].at - opened, 50ms) << "10 ms, with tolerance for a busy machine";
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

TEST(Keeper, AnswersTheFirmwareWhileTheCoverLineHums) {
  const Line line;
  const Cover cover(line);
  auto keeper = LampKeeper::start(with_cover(line, cover));
  ASSERT_TRUE(keeper) << keeper.error().message();
  ASSERT_TRUE(keeper->light(10s));
  std::string words;
  for (int i = 0; i < 2000; ++i) words += "oc";
  std::atomic<bool> hums = true;
  std::thread hum([&] {
    std::ofstream switch_line = cover.opened();
    while (hums) switch_line << words << std::flush;
  });
  EXPECT_FALSE(line.wait_for(2).back().lit);
  EXPECT_TRUE(keeper->turn_off());
  EXPECT_EQ(keeper->light(1s).error().code(), ErrorCode::kLampFailed) << "the cover may be open";
  hums = false;
  hum.join();
  EXPECT_EQ(line.changes().size(), 2U);
}

TEST(Keeper, SendsANoticeWhenItEnds) {
  const Line line;
  auto keeper = LampKeeper::start(line.settings());
  ASSERT_TRUE(keeper);
  ASSERT_TRUE(keeper->light(10s));
  ASSERT_EQ(::kill(keeper->process(), SIGKILL), 0);
  const auto notice = next_notice_of(*keeper);
  ASSERT_TRUE(notice);
  EXPECT_EQ(notice->kind, LampKeeper::Notice::Kind::kGone);
  EXPECT_FALSE(keeper->next_notice()) << "only once";
}

TEST(Keeper, ReportsAMissingProgram) {
  const Line line;
  LampKeeper::Settings settings = line.settings();
  settings.program = "/nowhere/plumbline-keeper";
  EXPECT_EQ(LampKeeper::start(settings).error().code(), ErrorCode::kLampFailed);
}

}  // namespace
}  // namespace plumbline
