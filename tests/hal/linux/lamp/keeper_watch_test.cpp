/// Keeper and firmware watch each other, with real processes: whoever stops is ended, and the lamp is dark.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <optional>
#include <random>

#include "hal/linux/lamp/lamp_watch.hpp"
#include "tests/hal/linux/lamp/keeper_line.hpp"

namespace plumbline {
namespace {

constexpr nanoseconds kDark = 50ms;

/// A firmware in a process of its own, which has lit the lamp or stays dark.
class Firmware {
 public:
  explicit Firmware(const Line& line) : Firmware(line, line.settings()) {}
  Firmware(const Line& line, const LampKeeper::Settings& settings, bool lit = true) {
    std::array<int, 2> pipe{};
    EXPECT_EQ(::pipe(pipe.data()), 0);
    process_ = ::fork();
    if (process_ == 0) {
      auto keeper = LampKeeper::start(settings);
      if (!keeper) ::_exit(3);
      const pid_t pid = keeper->process();
      if (::write(pipe[1], &pid, sizeof pid) != sizeof pid || (lit && !keeper->light(10s))) ::_exit(4);
      for (;;) ::pause();
    }
    EXPECT_EQ(::read(pipe[0], &keeper_, sizeof keeper_), ssize_t{sizeof keeper_});
    for (const int fd : pipe) ::close(fd);
    if (lit) {
      EXPECT_EQ(line.wait_for(1).size(), 1U);
    }
  }
  ~Firmware() {
    ::kill(process_, SIGKILL);
    static_cast<void>(status());
  }
  Firmware(const Firmware&) = delete;
  Firmware& operator=(const Firmware&) = delete;

  pid_t process() const { return process_; }
  pid_t keeper() const { return keeper_; }
  /// Returns when all its threads have stopped.
  void stop() const {
    int status = 0;
    ::kill(process_, SIGSTOP);
    EXPECT_EQ(::waitpid(process_, &status, WUNTRACED), process_);
    EXPECT_TRUE(WIFSTOPPED(status));
  }
  /// Waits for its end.
  int status() {
    if (!status_) {
      status_ = 0;
      ::waitpid(process_, &*status_, 0);
    }
    return *status_;
  }

 private:
  pid_t process_ = -1;
  pid_t keeper_ = -1;
  std::optional<int> status_;
};

/// The watchdog's device: a FIFO that the test reads.
class Device {
 public:
  explicit Device(const Line& line) : path_(line.folder() + "/watchdog") {
    EXPECT_EQ(::mkfifo(path_.c_str(), 0600), 0);
    file_ = ::open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  }
  ~Device() { ::close(file_); }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  void give_to(LampKeeper::Settings& settings) const {
    settings.watchdog = "file:" + path_;
    settings.watchdog_timeout = 2s;
  }
  /// What is written within a time.
  std::string written(std::chrono::milliseconds time) const {
    const auto until = monotonic_now() + time;
    std::string all;
    while (monotonic_now() < until) {
      pollfd fd{file_, POLLIN, 0};
      if (::poll(&fd, 1, 10) != 1) continue;
      std::array<char, 64> bytes{};
      const ssize_t got = ::read(file_, bytes.data(), bytes.size());
      if (got > 0) all.append(bytes.data(), static_cast<std::size_t>(got));
    }
    return all;
  }

 private:
  std::string path_;
  int file_ = -1;
};

void sleep_for(nanoseconds time) { sleep_until_monotonic(monotonic_now() + time); }

/// Stops or kills the keeper of a lit lamp. @returns from then until dark
nanoseconds dark_after(int signal, nanoseconds after) {
  const Line line;
  auto keeper = LampKeeper::start(line.settings());
  EXPECT_TRUE(keeper && keeper->light(10s));
  sleep_for(after);
  const auto sent = monotonic_now();
  EXPECT_EQ(::kill(keeper->process(), signal), 0);
  const auto changes = line.wait_for(2);
  EXPECT_EQ(changes.size(), 2U) << "still lit";
  EXPECT_TRUE(keeper->await_dark(1000ms));
  EXPECT_STREQ(keeper->reason(), signal == SIGSTOP ? "did not answer" : "has ended");
  EXPECT_EQ(keeper->next_notice()->kind, LampKeeper::Notice::Kind::kGone);
  EXPECT_EQ(keeper->light(1s).error().code(), ErrorCode::kLampFailed);
  return changes.back().at - sent;
}

TEST(KeeperWatch, TheFirmwareTurnsTheLampOffWithin50MsOfTheKeepersStop) {
  std::mt19937 random(11);
  for (int round = 0; round < 10; ++round) {
    EXPECT_LT(dark_after(SIGSTOP, std::chrono::microseconds(random() % 50'000)), kDark) << round;
  }
}

TEST(KeeperWatch, TheFirmwareTurnsTheLampOffWithin50MsOfTheKeepersDeath) {
  std::mt19937 random(12);
  for (int round = 0; round < 10; ++round) {
    EXPECT_LT(dark_after(SIGKILL, std::chrono::microseconds(random() % 50'000)), kDark) << round;
  }
}

TEST(KeeperWatch, TheKeeperTurnsTheLampOffWithin50MsOfTheFirmwaresStopAndEndsIt) {
  std::mt19937 random(13);
  for (int round = 0; round < 10; ++round) {
    const Line line;
    Firmware firmware(line);
    sleep_for(std::chrono::microseconds(random() % 50'000));
    const auto stopped = monotonic_now();
    ::kill(firmware.process(), SIGSTOP);
    const auto changes = line.wait_for(2);
    ASSERT_EQ(changes.size(), 2U);
    EXPECT_LT(changes[1].at - stopped, kDark) << round;
    EXPECT_TRUE(WIFSIGNALED(firmware.status()));
    EXPECT_EQ(WTERMSIG(firmware.status()), SIGKILL);
  }
}

TEST(KeeperWatch, AStoppedKeeperTurnsTheLampOffWhenItsFirmwareDies) {
  const Line line;
  const Firmware firmware(line);
  // A keeper that init adopts would be continued as an orphan. This process adopts it instead.
  ASSERT_EQ(::prctl(PR_SET_CHILD_SUBREAPER, 1), 0);
  // The firmware first: it would end a keeper that is stopped.
  firmware.stop();
  ::kill(firmware.keeper(), SIGSTOP);
  sleep_for(200ms);
  ASSERT_EQ(line.changes().size(), 1U) << "both are stopped: only the board's watchdog helps";
  const auto died = monotonic_now();
  ::kill(firmware.process(), SIGKILL);
  const auto changes = line.wait_for(2);
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_LT(changes[1].at - died, kDark);
  ::prctl(PR_SET_CHILD_SUBREAPER, 0);
}

TEST(KeeperWatch, AKeeperThatWasStoppedInTheDarkLightsNothingAndIsEndedWithin50MsOfTheNextRequest) {
  const Line line;
  auto keeper = LampKeeper::start(line.settings());
  ASSERT_TRUE(keeper) << keeper.error().message();
  ASSERT_EQ(::kill(keeper->process(), SIGSTOP), 0);
  const auto asked = monotonic_now();
  EXPECT_EQ(keeper->light(10s).error().code(), ErrorCode::kLampFailed);
  EXPECT_TRUE(keeper->await_dark(1000ms));
  EXPECT_LT(monotonic_now() - asked, kDark);
  EXPECT_STREQ(keeper->reason(), "did not answer");
  for (const auto& change : line.changes()) EXPECT_FALSE(change.lit);
}

TEST(KeeperWatch, NobodyIsBlamedWhenTheWholeBoardStoodStill) {
  const Line line;
  const Firmware firmware(line);
  for (const int signal : {SIGSTOP, SIGCONT}) {
    ::kill(firmware.process(), signal);
    ::kill(firmware.keeper(), signal);
    sleep_for(300ms);
  }
  EXPECT_EQ(line.changes().size(), 1U) << "still lit";
  EXPECT_EQ(::kill(firmware.keeper(), 0), 0);
}

TEST(KeeperWatch, TheNextKeeperFindsTheLineOfTheLastOneLitAndTurnsItOff) {
  const Line line;
  {
    const Firmware firmware(line);
    firmware.stop();
    ::kill(firmware.keeper(), SIGKILL);
  }
  ASSERT_EQ(line.changes().size(), 1U) << "a released line stays lit";
  const auto keeper = LampKeeper::start(line.settings());
  ASSERT_TRUE(keeper) << keeper.error().message();
  ASSERT_EQ(line.changes().size(), 2U);
  EXPECT_FALSE(line.changes().back().lit);
}

TEST(KeeperWatch, FeedsTheWatchdogOnlyWhileBothAreWell) {
  for (const bool stop_keeper : {false, true}) {
    const Line line;
    const Device device(line);
    LampKeeper::Settings settings = line.settings();
    device.give_to(settings);
    const Firmware firmware(line, settings);
    const auto fed = device.written(1000ms);
    EXPECT_GE(fed.size(), 3U) << "four times a second";
    EXPECT_LE(fed.size(), 5U);
    ::kill(stop_keeper ? firmware.keeper() : firmware.process(), SIGSTOP);
    sleep_for(50ms);
    static_cast<void>(device.written(20ms));
    EXPECT_EQ(device.written(800ms), "") << "and it was not stopped either";
  }
}

// In the dark the firmware is ended only after a second.
TEST(KeeperWatch, DoesNotFeedTheWatchdogForAFirmwareThatIsSilentInTheDark) {
  const Line line;
  const Device device(line);
  LampKeeper::Settings settings = line.settings();
  device.give_to(settings);
  const Firmware firmware(line, settings, false);
  EXPECT_FALSE(device.written(1000ms).empty());
  ::kill(firmware.process(), SIGSTOP);
  EXPECT_LE(device.written(900ms).size(), 2U) << "the ticks in which the last pings came";
  EXPECT_EQ(::kill(firmware.process(), 0), 0);
}

TEST(KeeperWatch, StopsTheWatchdogWhenTheFirmwareEndsInOrder) {
  const Line line;
  const Device device(line);
  LampKeeper::Settings settings = line.settings();
  device.give_to(settings);
  {
    auto keeper = LampKeeper::start(settings);
    ASSERT_TRUE(keeper && keeper->light(10s));
  }
  const auto written = device.written(100ms);
  ASSERT_FALSE(written.empty());
  EXPECT_EQ(written.find('V'), written.size() - 1) << "the last byte";
  EXPECT_FALSE(line.changes().back().lit);
}

TEST(KeeperWatch, RefusesToStartWithoutTheWatchdogOfTheBoardFile) {
  const Line line;
  LampKeeper::Settings settings = line.settings();
  settings.watchdog = line.folder() + "/nothing";
  EXPECT_EQ(LampKeeper::start(settings).error().code(), ErrorCode::kLampFailed);
}

TEST(KeeperWatch, RefusesMoreLightThanTheBoardAllowsWhateverTheFirmwareAsksFor) {
  const Line line;
  LampKeeper::Settings settings = line.settings();
  settings.limits = {.longest = 300ms, .per_minute = 500ms};
  auto keeper = LampKeeper::start(settings);
  ASSERT_TRUE(keeper);
  EXPECT_EQ(keeper->light(301ms).error().code(), ErrorCode::kExposureTooLong);
  ASSERT_TRUE(keeper->light(300ms));
  ASSERT_EQ(line.wait_for(2).size(), 2U);
  EXPECT_EQ(keeper->light(250ms).error().code(), ErrorCode::kExposureTooLong) << "550 ms in a minute";
  EXPECT_EQ(line.changes().size(), 2U);
  EXPECT_TRUE(keeper->light(150ms));
}

/// Drains until there is an event; at most for 2 s.
std::optional<Event> next_event(LampWatch& watch, EventQueue& queue) {
  const auto until = monotonic_now() + 2s;
  for (auto event = queue.take();; event = queue.take()) {
    if (event || monotonic_now() > until) return event;
    watch.drain(monotonic_now());
    ::usleep(500);
  }
}

TEST(LampWatch, ReplacesAKeeperThatIsGoneAndTellsTheExposureWhy) {
  for (const int signal : {SIGSTOP, SIGKILL}) {
    const Line line;
    EventQueue queue;
    auto watch = LampWatch::start(line.settings(), queue);
    ASSERT_TRUE(watch) << watch.error().message();
    LampKeeper* const first = (*watch)->keeper().value();
    const pid_t first_process = first->process();
    const auto lit = first->light(10s);
    ASSERT_TRUE(lit);
    (*watch)->on_lit(*lit);
    ASSERT_EQ(::kill(first_process, signal), 0);
    const auto event = next_event(**watch, queue);
    ASSERT_TRUE(event);
    EXPECT_EQ(event->kind, EventKind::kExposureEnded);
    EXPECT_FALSE((*watch)->lit());
    ASSERT_NE((*watch)->cut_by_loss(), nullptr);
    EXPECT_STREQ((*watch)->cut_by_loss(), signal == SIGSTOP ? "did not answer" : "has ended");
    const auto next = (*watch)->keeper();
    ASSERT_TRUE(next) << next.error().message();
    EXPECT_NE((*next)->process(), first_process);
    const auto again = (*next)->light(10s);
    ASSERT_TRUE(again) << again.error().message();
    (*watch)->on_lit(*again);
    EXPECT_EQ((*watch)->cut_by_loss(), nullptr);
    EXPECT_EQ(line.changes().size(), 3U) << "on, off, on";
  }
}

// Nobody watches the switch then.
TEST(LampWatch, TakesTheCoverForOpenWhileThereIsNoKeeper) {
  const Line line;
  const std::string cover = line.folder() + "/cover";
  ASSERT_EQ(::mkfifo(cover.c_str(), 0600), 0);
  LampKeeper::Settings settings = line.settings();
  settings.cover = "file:" + cover;
  const std::string program = line.folder() + "/keeper";
  std::filesystem::create_symlink(settings.program, program);
  settings.program = program;
  EventQueue queue;
  auto watch = LampWatch::start(settings, queue);
  ASSERT_TRUE(watch) << watch.error().message();
  EXPECT_FALSE((*watch)->cover_open());
  const pid_t process = (*watch)->keeper().value()->process();
  std::filesystem::remove(program);
  ASSERT_EQ(::kill(process, SIGKILL), 0);
  const auto until = monotonic_now() + 10s;
  while (!(*watch)->cover_open() && monotonic_now() < until) {
    (*watch)->drain(monotonic_now());
    ::usleep(500);
  }
  EXPECT_TRUE((*watch)->cover_open());
  EXPECT_FALSE((*watch)->keeper());
}

// A print that is resumed after each loss of a keeper must not get more light in a minute for that.
TEST(LampWatch, TellsTheNextKeeperHowMuchLightTheLastMinuteHad) {
  const Line line;
  EventQueue queue;
  LampKeeper::Settings settings = line.settings();
  settings.limits = {.longest = 2s, .per_minute = 2s};
  auto watch = LampWatch::start(settings, queue);
  ASSERT_TRUE(watch) << watch.error().message();
  LampKeeper* const first = (*watch)->keeper().value();
  const auto lit = first->light(2s);
  ASSERT_TRUE(lit);
  (*watch)->on_lit(*lit);
  sleep_for(300ms);
  ASSERT_EQ(::kill(first->process(), SIGKILL), 0);
  ASSERT_TRUE(next_event(**watch, queue));
  const auto next = (*watch)->keeper();
  ASSERT_TRUE(next) << next.error().message();
  EXPECT_EQ((*next)->light(1800ms).error().code(), ErrorCode::kExposureTooLong) << "2.1 s in a minute";
  EXPECT_EQ(line.changes().size(), 2U);
  EXPECT_TRUE((*next)->light(1s));
}

}  // namespace
}  // namespace plumbline
