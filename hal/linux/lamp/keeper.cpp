#include "hal/linux/lamp/keeper.hpp"

#include <poll.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <ctime>

#include "hal/linux/gpio/contact.hpp"
#include "hal/linux/gpio/edges.hpp"
#include "hal/linux/lamp/keeper_protocol.hpp"

namespace plumbline {
namespace {

/// The timer goes off this long before an exposure's end, ns, and the clock is watched from there: how late a process wakes is the
/// scheduler's, up to a millisecond on a slow board.
constexpr std::int64_t kWatched = 500'000;

std::int64_t now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

class Keeper {
 public:
  Keeper(LampLine& line, CoverLine* cover, int socket, int timer)
      : line_(line), cover_(cover), socket_(socket), timer_(timer), open_(cover != nullptr && cover->open()) {
    tell_cover(now_ns());
  }

  void darken() {
    stuck_ = !line_.set(false);
    if (stuck_) return;
    if (lit_) answer(KeeperWord::kDark, lit_request_);
    lit_ = false;
  }

  /// The timer has gone off.
  void end_exposure() {
    while (lit_ && now_ns() < end_) {
    }
    darken();
  }

  /// The line could not be turned off: darken() is to be tried again.
  bool stuck() const { return stuck_; }

  /// What the cover's switch has done: light ends at the first contact, before anybody is told.
  void look_at_cover() {
    if (cover_ == nullptr) return;
    see_edges(*cover_, [&](const CoverLine::Edge& edge) { saw_cover(edge.open, edge.at); });
    // The edges of a bounce may be more than the kernel keeps.
    const Contact::Time now(now_ns());
    saw_cover(cover_->open(), now);
    if (const auto closed = open_.settle(now)) tell_cover(closed->count());
  }

  /// For poll(): until the cover's contact has come to rest.
  int wait_ms() const {
    constexpr int kRetryMs = 1;
    if (stuck_) return kRetryMs;
    const auto due = open_.due();
    if (!due) return -1;
    return static_cast<int>(std::max<std::int64_t>(0, (due->count() - now_ns()) / 1'000'000 + 1));
  }

  /// @returns false: the firmware has gone
  bool hear() {
    KeeperMessage message;
    const ssize_t got = ::recv(socket_, &message, sizeof message, MSG_DONTWAIT);
    if (got < 0) return errno == EAGAIN || errno == EINTR;
    if (got != sizeof message || message.magic != KeeperMessage::kMagic) return false;
    switch (message.word) {
      case KeeperWord::kLight: light(message); return true;
      case KeeperWord::kDarken:
        if (!lit_) {
          answer(KeeperWord::kDark, message.request);
        } else {
          darken();
        }
        return true;
      case KeeperWord::kLit:
      case KeeperWord::kDark:
      case KeeperWord::kFailed:
      case KeeperWord::kCoverOpened:
      case KeeperWord::kCoverClosed: return false;
    }
    return false;
  }

 private:
  void light(const KeeperMessage& message) {
    look_at_cover();
    if (lit_ || open_.on() || message.nanoseconds <= 0 || message.nanoseconds > kKeeperLongestNs) {
      answer(KeeperWord::kFailed, message.request);
      return;
    }
    if (!arm(0, message.nanoseconds)) {
      answer(KeeperWord::kFailed, message.request);
      return;
    }
    lit_ = line_.set(true);
    lit_request_ = message.request;
    if (!lit_) {
      static_cast<void>(line_.set(false));
      answer(KeeperWord::kFailed, message.request);
      return;
    }
    // The time that passed between arming and light is given back: where it can't be, the light is shorter by it.
    const std::int64_t on_at = now_ns();
    end_ = on_at + message.nanoseconds;
    static_cast<void>(arm(TFD_TIMER_ABSTIME, end_ - kWatched));
    say(KeeperWord::kLit, message.request, on_at);
  }

  bool arm(int flags, std::int64_t nanoseconds) const {
    itimerspec deadline{};
    deadline.it_value.tv_sec = static_cast<time_t>(nanoseconds / 1'000'000'000);
    deadline.it_value.tv_nsec = static_cast<long>(nanoseconds % 1'000'000'000);
    return ::timerfd_settime(timer_, flags, &deadline, nullptr) == 0;
  }

  void saw_cover(bool open, Contact::Time at) {
    if (!open_.saw(open, at)) return;
    if (lit_) {
      // Dark first; that it is dark is said after why.
      stuck_ = !line_.set(false);
      tell_cover(at.count());
      darken();
    } else {
      tell_cover(at.count());
    }
  }

  void tell_cover(std::int64_t at) const {
    if (cover_ != nullptr) say(open_.on() ? KeeperWord::kCoverOpened : KeeperWord::kCoverClosed, 0, at);
  }

  void answer(KeeperWord word, std::uint64_t request) const { say(word, request, now_ns()); }

  void say(KeeperWord word, std::uint64_t request, std::int64_t at) const {
    KeeperMessage message;
    message.word = word;
    message.request = request;
    message.nanoseconds = at;
    // Who does not listen any more is noticed by the end of the socket.
    static_cast<void>(::send(socket_, &message, sizeof message, MSG_DONTWAIT | MSG_NOSIGNAL));
  }

  LampLine& line_;
  CoverLine* cover_;
  int socket_;
  int timer_;
  Contact open_;
  bool lit_ = false;
  bool stuck_ = false;
  std::int64_t end_ = 0;  ///< of the light, CLOCK_MONOTONIC, ns
  std::uint64_t lit_request_ = 0;
};

}  // namespace

int keep_lamp(LampLine& line, CoverLine* cover, int socket, int firmware) {
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) ::sigaddset(&signals, number);
  ::sigprocmask(SIG_BLOCK, &signals, nullptr);
  const int told = ::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
  const int timer = ::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
  // By number: the C library of Debian 12 has the call, older ones do not.
  const int process = static_cast<int>(::syscall(SYS_pidfd_open, firmware, 0));
  if (told < 0 || timer < 0 || process < 0) return 1;

  Keeper keeper(line, cover, socket, timer);
  bool serving = true;
  while (serving) {
    // poll() leaves out descriptors below 0 and reports hang-ups unasked.
    std::array<pollfd, 5> fds = {{{socket, POLLIN, 0},
                                  {timer, POLLIN, 0},
                                  {process, POLLIN, 0},
                                  {told, POLLIN, 0},
                                  {cover == nullptr ? -1 : cover->descriptor(), POLLIN, 0}}};
    if (::poll(fds.data(), fds.size(), keeper.wait_ms()) < 0 && errno != EINTR) break;
    if (keeper.stuck()) keeper.darken();
    keeper.look_at_cover();
    std::uint64_t times = 0;
    if (::read(timer, &times, sizeof times) == sizeof times) keeper.end_exposure();
    if ((fds[2].revents | fds[3].revents) != 0) serving = false;
    if (fds[0].revents != 0 && !keeper.hear()) serving = false;
  }
  keeper.darken();
  for (int tries = 0; tries < 1000 && !line.set(false); ++tries) ::usleep(1000);
  for (const int fd : {told, timer, process}) ::close(fd);
  return 0;
}

}  // namespace plumbline
