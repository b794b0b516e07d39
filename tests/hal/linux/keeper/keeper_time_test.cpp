/// The keeper in virtual time: this program is linked with --wrap (tests/CMakeLists.txt), so that what it asks of the kernel comes to a
/// VirtualKernel. So each change of the line has the time that it was asked for, to the microsecond, on a machine however busy.

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/keeper/keeper.hpp"
#include "hal/linux/keeper/keeper_protocol.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

constexpr int kRequests = 100'000;  // descriptors that no process has
constexpr int kPings = 100'001;
constexpr int kCover = 100'002;
constexpr nanoseconds kNever{std::numeric_limits<std::int64_t>::max()};
/// What a call takes, so that a keeper that spins gets on.
constexpr nanoseconds kCall = 1us;

/// Plays clock, timer, sockets and the firmware's process.
class VirtualKernel {
 public:
  VirtualKernel() {
    firmware_ = ::fork();
    if (firmware_ == 0) {
      for (;;) ::pause();
    }
  }
  ~VirtualKernel() {
    ::kill(firmware_, SIGKILL);
    if (!ended_) ::waitpid(firmware_, nullptr, 0);
  }
  VirtualKernel(const VirtualKernel&) = delete;
  VirtualKernel& operator=(const VirtualKernel&) = delete;

  /// Something happens at a time.
  void at(nanoseconds when, std::function<void()> what) { script_.emplace(when, std::move(what)); }
  /// The firmware pings from here on.
  void pings_until(nanoseconds end) { pings_end_ = end; }
  void asks(KeeperWord word, std::uint64_t request, nanoseconds time = {}) {
    KeeperMessage message;
    message.word = word;
    message.request = request;
    message.nanoseconds = time.count();
    requests_.push_back(message);
  }

  /// How the firmware's process ended: a signal, or 0 while it lives.
  int killed_by() {
    int status = 0;
    ended_ = ended_ || ::waitpid(firmware_, &status, WNOHANG) == firmware_;
    for (int tries = 0; !ended_ && tries < 100; ++tries) {  // a kill takes a moment of real time
      ::poll(nullptr, 0, 1);
      ended_ = ::waitpid(firmware_, &status, WNOHANG) == firmware_;
    }
    return ended_ && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }
  pid_t firmware() const { return firmware_; }
  const std::vector<KeeperMessage>& sent() const { return sent_; }
  std::vector<KeeperWord> words() const {
    std::vector<KeeperWord> words;
    for (const auto& message : sent_) words.push_back(message.word);
    return words;
  }

  nanoseconds now = 1000s;
  nanoseconds timer = kNever;  ///< when it fires
  int failing_timers = 0;      ///< further settings of the timer that fail
  nanoseconds late{};          ///< by which the scheduler wakes the keeper after its timer
  int signalled = 0;           ///< SIGTERM waits

  // What is asked of the kernel.

  int poll(std::span<pollfd> fds, nanoseconds timeout) {
    now += kCall;
    if (now > 10'000s) throw std::runtime_error("the keeper waits for ever");
    const nanoseconds end = now + timeout;
    for (;;) {
      const nanoseconds next_ping = next_ping_ <= pings_end_ ? next_ping_ : kNever;
      const nanoseconds next_word = script_.empty() ? kNever : script_.begin()->first;
      const nanoseconds next = std::min({end, next_ping, next_word, timer});
      if (next > now) now = next;
      if (next == next_word) {
        const auto what = std::move(script_.begin()->second);
        script_.erase(script_.begin());
        what();
      } else if (next == next_ping) {
        pings_waiting_ = true;
        next_ping_ = now + 5ms;
      } else if (next == timer && timer != kNever) {
        now += late;
        fired_ = true;
        timer = kNever;
      }
      if (settle(fds) || next == end) return 1;
    }
  }
  int set_timer(int flags, nanoseconds time) {
    now += kCall;
    if (failing_timers > 0 && failing_timers-- > 0) return -1;
    timer = flags == TFD_TIMER_ABSTIME ? time : now + time;
    fired_ = false;
    return 0;
  }
  bool take_timer() { return std::exchange(fired_, false); }
  ssize_t receive(int socket, std::span<std::byte> bytes) {
    if (socket == kPings && std::exchange(pings_waiting_, false)) {
      const KeeperPing ping = ++ping_;
      std::memcpy(bytes.data(), &ping, sizeof ping);
      return sizeof ping;
    }
    if (socket == kRequests && !requests_.empty()) {
      std::memcpy(bytes.data(), &requests_.front(), sizeof(KeeperMessage));
      requests_.pop_front();
      return sizeof(KeeperMessage);
    }
    errno = EAGAIN;
    return -1;
  }
  void send(int socket, const void* bytes) {
    if (socket != kRequests) return;
    KeeperMessage message;
    std::memcpy(&message, bytes, sizeof message);
    sent_.push_back(message);
  }
  bool edge_waits = false;

 private:
  /// @returns whether a descriptor is ready
  bool settle(std::span<pollfd> fds) const {
    bool any = false;
    for (std::size_t i = 0; i < fds.size(); ++i) {
      pollfd& fd = fds[i];
      const bool ready = (fd.fd == kRequests && !requests_.empty()) || (fd.fd == kPings && pings_waiting_) ||
                         (fd.fd == kCover && edge_waits) || (i == 1 && fired_) || (i == 3 && signalled != 0);
      fd.revents = ready ? POLLIN : short{0};
      any = any || ready;
    }
    return any;
  }

  pid_t firmware_ = -1;
  bool ended_ = false;
  std::multimap<nanoseconds, std::function<void()>> script_;
  std::deque<KeeperMessage> requests_;
  std::vector<KeeperMessage> sent_;
  nanoseconds next_ping_ = now;
  nanoseconds pings_end_ = kNever;
  bool pings_waiting_ = false;
  KeeperPing ping_ = 0;
  bool fired_ = false;
};

VirtualKernel* kernel = nullptr;
int virtual_timer = -1;  ///< its descriptor

struct LineChange {
  bool lit;
  nanoseconds at;
  nanoseconds timer;         ///< when it would fire
  std::size_t words_before;  ///< that the keeper has sent
};

class VirtualLine final : public LampLine {
 public:
  bool set(bool lit) noexcept override {
    kernel->now += kCall;
    if (lit ? failing_on > 0 && failing_on-- > 0 : failing_off > 0 && failing_off-- > 0) return false;
    if (lit != lit_) changes.push_back({lit, kernel->now, kernel->timer, kernel->sent().size()});
    lit_ = lit;
    if (lit && breaks_the_timer) kernel->failing_timers = 1;
    return true;
  }
  bool breaks_the_timer = false;
  int failing_on = 0, failing_off = 0;
  std::vector<LineChange> changes;

 private:
  bool lit_ = false;
};

class VirtualCover final : public CoverLine {
 public:
  void set(bool open) {
    open_ = open;
    edges_.push_back({open, kernel->now});
    kernel->edge_waits = true;
  }
  bool open() const noexcept override { return open_; }
  std::optional<Edge> next_edge() noexcept override {
    if (edges_.empty()) return std::nullopt;
    const Edge edge = edges_.front();
    edges_.pop_front();
    kernel->edge_waits = !edges_.empty();
    return edge;
  }
  int descriptor() const override { return kCover; }

 private:
  bool open_ = false;
  std::deque<Edge> edges_;
};

/// A keeper from its start, at 1000 s, to its end.
class KeeperTime : public testing::Test {
 protected:
  KeeperTime() {
    ::sigprocmask(SIG_SETMASK, nullptr, &mask_);
    kernel = &kernel_;
  }
  ~KeeperTime() override {
    kernel = nullptr;
    ::sigprocmask(SIG_SETMASK, &mask_, nullptr);
  }

  void light_at(nanoseconds when, std::uint64_t request, nanoseconds cure) {
    kernel_.at(when, [this, request, cure] { kernel_.asks(KeeperWord::kLight, request, cure); });
  }
  void run(nanoseconds end) {
    kernel_.at(end, [this] { kernel_.asks(KeeperWord::kEnd, 99); });
    EXPECT_EQ(keep_lamp({.line = line_,
                         .cover = has_cover_ ? &cover_ : nullptr,
                         .watchdog = watchdog_ ? &*watchdog_ : nullptr,
                         .socket = kRequests,
                         .watch_socket = kPings,
                         .firmware = kernel_.firmware(),
                         .limits = limits_,
                         .lit_before = lit_before_}),
              0);
    EXPECT_TRUE(line_.changes.empty() || !line_.changes.back().lit) << "a keeper leaves the lamp dark";
  }
  /// From on to off, of the exposures in their order.
  std::vector<nanoseconds> lit() const {
    std::vector<nanoseconds> times;
    for (std::size_t i = 1; i < line_.changes.size(); i += 2) {
      times.push_back(line_.changes[i].at - line_.changes[i - 1].at);
    }
    return times;
  }
  bool has_word(KeeperWord word) const {
    const auto words = kernel_.words();
    return std::find(words.begin(), words.end(), word) != words.end();
  }

  VirtualKernel kernel_;
  VirtualLine line_;
  VirtualCover cover_;
  bool has_cover_ = false;
  std::optional<Watchdog> watchdog_;
  LightLimits limits_{.longest = 60s, .per_minute = 60s};
  nanoseconds lit_before_{};

 private:
  sigset_t mask_{};
};

constexpr nanoseconds kExact = 20us;  // some calls

TEST_F(KeeperTime, EndsEachExposureAtItsDeadlineHoweverLateItWakes) {
  nanoseconds when = 1001s;
  std::vector<nanoseconds> asked;
  for (const nanoseconds cure :
       {nanoseconds(1ms), nanoseconds(3ms), nanoseconds(50ms), nanoseconds(2500ms), nanoseconds(10s)}) {
    light_at(when, asked.size() + 1, cure);
    when += cure + 1s;
    asked.push_back(cure);
  }
  kernel_.late = 400us;  // the keeper wakes half a millisecond early, for that
  run(when);
  const auto lit_times = lit();
  ASSERT_EQ(lit_times.size(), asked.size());
  for (std::size_t i = 0; i < asked.size(); ++i) {
    EXPECT_GE(lit_times[i], asked[i]) << i;
    EXPECT_LE(lit_times[i], asked[i] + kExact) << i;
  }
}

TEST_F(KeeperTime, ArmsItsTimerBeforeTheLineGoesOn) {
  light_at(1001s, 1, 5s);
  run(1010s);
  ASSERT_EQ(line_.changes.size(), 2U);
  EXPECT_LE(line_.changes[0].timer - line_.changes[0].at, 5s);
  EXPECT_GT(line_.changes[0].timer, line_.changes[0].at) << "armed, and not fired yet";
}

TEST_F(KeeperTime, LightsNothingWithoutATimer) {
  kernel_.at(1001s, [this] {
    kernel_.failing_timers = 1;
    kernel_.asks(KeeperWord::kLight, 1, 5s);
  });
  run(1010s);
  EXPECT_TRUE(line_.changes.empty());
  EXPECT_TRUE(has_word(KeeperWord::kFailed));
}

// The first arming holds then.
TEST_F(KeeperTime, EndsNoLaterIfTheTimerCannotBeArmedAgain) {
  line_.breaks_the_timer = true;
  light_at(1001s, 1, 5s);
  run(1010s);
  ASSERT_EQ(lit().size(), 1U);
  EXPECT_GE(lit()[0], 5s - kExact);
  EXPECT_LE(lit()[0], 5s + kExact);
}

TEST_F(KeeperTime, CountsTheLightOfTheKeeperBeforeItForAMinute) {
  limits_.per_minute = 40s;
  lit_before_ = 30s;
  light_at(1001s, 1, 11s);  // 41 s with those before 1000 s
  light_at(1002s, 2, 10s);  // 40 s
  light_at(1013s, 3, 1s);   // 41 s
  light_at(1072s, 4, 39s);  // none of the first 30 s is left, and none of the 10 s until 1012 s
  run(1200s);
  EXPECT_EQ(lit().size(), 2U);
  std::vector<std::uint64_t> refused;
  for (const auto& message : kernel_.sent()) {
    if (message.word == KeeperWord::kRefused) refused.push_back(message.request);
  }
  EXPECT_EQ(refused, (std::vector<std::uint64_t>{1, 3}));
}

TEST_F(KeeperTime, CountsItsOwnLightHoweverAnExposureEnded) {
  limits_.per_minute = 10s;
  has_cover_ = true;
  light_at(1001s, 1, 9s);
  kernel_.at(1004s, [this] { kernel_.asks(KeeperWord::kTurnOff, 2); });  // 3 s
  light_at(1005s, 3, 7s);
  kernel_.at(1009s, [this] { cover_.set(true); });  // 4 s
  kernel_.at(1010s, [this] { cover_.set(false); });
  light_at(1012s, 4, 3s + 10ms);
  light_at(1013s, 5, 3s - 10ms);
  run(1020s);
  ASSERT_EQ(lit().size(), 3U);
  EXPECT_TRUE(has_word(KeeperWord::kRefused));
}

TEST_F(KeeperTime, DarkensTheLampBeforeItSaysThatTheCoverIsOpen) {
  has_cover_ = true;
  light_at(1001s, 1, 9s);
  kernel_.at(1003s, [this] { cover_.set(true); });
  light_at(1004s, 2, 1s);  // refused: still open
  kernel_.at(1005s, [this] { cover_.set(false); });
  light_at(1005s + 20ms, 3, 1s);  // the contact has not settled
  light_at(1006s, 4, 1s);
  run(1010s);
  ASSERT_EQ(line_.changes.size(), 4U);
  EXPECT_LE(line_.changes[1].at - 1003s, kExact);
  const auto words = kernel_.words();
  const auto opened =
      static_cast<std::size_t>(std::find(words.begin(), words.end(), KeeperWord::kCoverOpened) - words.begin());
  EXPECT_EQ(line_.changes[1].words_before, opened) << "off, then the reason";
  ASSERT_LT(opened + 1, words.size());
  EXPECT_EQ(words[opened + 1], KeeperWord::kDark);
  EXPECT_EQ(std::count(words.begin(), words.end(), KeeperWord::kFailed), 2);
}

TEST_F(KeeperTime, DarkensALampWhoseFirmwareFallsSilentAndEndsIt) {
  light_at(1001s, 1, 30s);
  kernel_.pings_until(1005s);
  run(2000s);
  ASSERT_EQ(line_.changes.size(), 2U);
  EXPECT_GE(line_.changes[1].at - 1005s, 20ms);
  EXPECT_LE(line_.changes[1].at - 1005s, 31ms);
  EXPECT_EQ(kernel_.killed_by(), SIGKILL);
}

TEST_F(KeeperTime, LeavesAFirmwareThatAnswersAlone) {
  light_at(1001s, 1, 30s);
  run(1040s);
  EXPECT_EQ(line_.changes.size(), 2U);
  EXPECT_EQ(kernel_.killed_by(), 0);
}

TEST_F(KeeperTime, GivesNoLightToAFirmwareThatDoesNotWatchIt) {
  kernel_.pings_until(0s);
  light_at(1001s, 1, 1s);
  run(1003s);
  EXPECT_TRUE(line_.changes.empty());
  EXPECT_TRUE(has_word(KeeperWord::kFailed));
}

TEST_F(KeeperTime, TriesALineThatDoesNotGoOffAgainEachMillisecond) {
  light_at(1001s, 1, 1s);
  kernel_.at(1001s + 500ms, [this] { line_.failing_off = 7; });
  run(1010s);
  ASSERT_EQ(line_.changes.size(), 2U);
  EXPECT_LE(line_.changes[1].at - line_.changes[0].at, 1s + 10ms);
  EXPECT_TRUE(has_word(KeeperWord::kDark));
}

TEST_F(KeeperTime, TriesALineThatDoesNotGoOffAlsoAfterItsFirmwareHasEnded) {
  light_at(1001s, 1, 30s);
  kernel_.at(1002s, [this] {
    line_.failing_off = 300;
    kernel_.signalled = 1;
  });
  run(1010s);
  EXPECT_EQ(line_.changes.size(), 2U);
}

TEST_F(KeeperTime, LightsNothingIfTheLineDoesNotGoOn) {
  kernel_.at(1001s, [this] {
    line_.failing_on = 1;
    kernel_.asks(KeeperWord::kLight, 1, 1s);
  });
  light_at(1003s, 2, 1s);
  run(1010s);
  EXPECT_EQ(line_.changes.size(), 2U);
  EXPECT_TRUE(has_word(KeeperWord::kFailed));
}

/// With a watchdog whose device is a file.
class KeeperTimeWatchdog : public KeeperTime {
 protected:
  KeeperTimeWatchdog() {
    const int file = ::mkstemp(path_.data());
    EXPECT_GE(file, 0);
    ::close(file);
    watchdog_.emplace(Watchdog::open("file:" + path_, 2s).value());
  }
  ~KeeperTimeWatchdog() override { ::unlink(path_.c_str()); }

  std::string written() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

 private:
  std::string path_ = (std::filesystem::temp_directory_path() / "plumbline-watchdog-XXXXXX").string();
};

TEST_F(KeeperTimeWatchdog, IsFedFourTimesASecondAndStoppedAtTheEnd) {
  light_at(1002s, 1, 5s);
  run(1010s);
  const std::string bytes = written();
  EXPECT_NEAR(static_cast<double>(bytes.size()), 40, 3);
  EXPECT_EQ(bytes.find('V'), bytes.size() - 1) << "the last byte";
}

TEST_F(KeeperTimeWatchdog, IsNeitherFedNorStoppedForAFirmwareThatIsSilent) {
  kernel_.pings_until(1005s);
  std::size_t fed = 0;
  kernel_.at(1005s + 400ms, [&] { fed = written().size(); });
  run(2000s);
  EXPECT_GT(fed, 15U);
  EXPECT_EQ(written().size(), fed);
  EXPECT_EQ(written().find('V'), std::string::npos);
  EXPECT_EQ(kernel_.killed_by(), SIGKILL);
}

}  // namespace

// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
extern "C" {
int __real_clock_gettime(clockid_t id, timespec* time);
int __real_timerfd_settime(int file, int flags, const itimerspec* value, itimerspec* old);
int __real_ppoll(pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* mask);
ssize_t __real_read(int file, void* bytes, std::size_t size);
ssize_t __real_recv(int file, void* bytes, std::size_t size, int flags);
ssize_t __real_send(int file, const void* bytes, std::size_t size, int flags);
int __real_usleep(useconds_t time);
pid_t __real_getppid();

int __wrap_clock_gettime(clockid_t id, timespec* time) {
  if (kernel == nullptr || id != CLOCK_MONOTONIC) return __real_clock_gettime(id, time);
  kernel->now += kCall;
  time->tv_sec = static_cast<time_t>(kernel->now / 1s);
  time->tv_nsec = static_cast<long>((kernel->now % 1s).count());
  return 0;
}
int __wrap_timerfd_settime(int file, int flags, const itimerspec* value, itimerspec* old) {
  if (kernel == nullptr) return __real_timerfd_settime(file, flags, value, old);
  virtual_timer = file;
  return kernel->set_timer(flags, std::chrono::seconds(value->it_value.tv_sec) + nanoseconds(value->it_value.tv_nsec));
}
int __wrap_ppoll(pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* mask) {
  if (kernel == nullptr) return __real_ppoll(fds, count, timeout, mask);
  return kernel->poll({fds, count}, std::chrono::seconds(timeout->tv_sec) + nanoseconds(timeout->tv_nsec));
}
ssize_t __wrap_read(int file, void* bytes, std::size_t size) {
  if (kernel == nullptr || file != virtual_timer) return __real_read(file, bytes, size);
  if (kernel->take_timer()) return sizeof(std::uint64_t);
  errno = EAGAIN;
  return -1;
}
ssize_t __wrap_recv(int file, void* bytes, std::size_t size, int flags) {
  if (kernel == nullptr || file < kRequests) return __real_recv(file, bytes, size, flags);
  return kernel->receive(file, {static_cast<std::byte*>(bytes), size});
}
ssize_t __wrap_send(int file, const void* bytes, std::size_t size, int flags) {
  if (kernel == nullptr || file < kRequests) return __real_send(file, bytes, size, flags);
  kernel->send(file, bytes);
  return static_cast<ssize_t>(size);
}
int __wrap_usleep(useconds_t time) {
  if (kernel == nullptr) return __real_usleep(time);
  kernel->now += std::chrono::microseconds(time);
  return 0;
}
pid_t __wrap_getppid() { return kernel == nullptr ? __real_getppid() : kernel->firmware(); }
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

}  // namespace plumbline
