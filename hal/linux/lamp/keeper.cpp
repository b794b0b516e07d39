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

/// The timer fires this long before an exposure's end, ns; from there the keeper spins. A scheduler may wake a process late, on a
/// slow board by up to 1 ms. A longer spin catches more of that and costs a core for longer in each layer.
constexpr std::int64_t kSpinTime = 500'000;

std::int64_t now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

class Keeper {
 public:
  Keeper(LampLine& line, CoverLine* cover, int socket, int timer)
      : line_(line), cover_(cover), socket_(socket), timer_(timer), cover_contact_(cover != nullptr && cover->open()) {
    report_cover(now_ns());
  }

  void turn_off() {
    stuck_ = !line_.set(false);
    if (stuck_) return;
    if (lit_) reply(KeeperWord::kDark, lit_request_);
    lit_ = false;
  }

  /// Called when the timer has fired.
  void end_exposure() {
    while (lit_ && now_ns() < end_) {
    }
    turn_off();
  }

  /// Whether the line could not be turned off: call turn_off() again.
  bool stuck() const { return stuck_; }

  /// Reads the cover switch. The first contact turns the lamp off before anything is sent.
  void poll_cover() {
    if (cover_ == nullptr) return;
    for_each_edge(*cover_, [&](const CoverLine::Edge& edge) { on_cover_edge(edge.open, edge.at); });
    // A bounce may have more edges than the kernel buffers.
    const Contact::Time now(now_ns());
    on_cover_edge(cover_->open(), now);
    if (const auto closed = cover_contact_.settle(now)) report_cover(closed->count());
  }

  /// Timeout for poll(), ms: until the next retry, or until the cover's contact has settled.
  int wait_ms() const {
    constexpr int kRetryMs = 1;
    if (stuck_) return kRetryMs;
    const auto due = cover_contact_.due();
    if (!due) return -1;
    return static_cast<int>(std::max<std::int64_t>(0, (due->count() - now_ns()) / 1'000'000 + 1));
  }

  /// Handles a message. @returns false if the firmware is gone
  bool receive() {
    KeeperMessage message;
    const ssize_t got = ::recv(socket_, &message, sizeof message, MSG_DONTWAIT);
    if (got < 0) return errno == EAGAIN || errno == EINTR;
    if (got != sizeof message || message.magic != KeeperMessage::kMagic) return false;
    switch (message.word) {
      case KeeperWord::kLight: light(message); return true;
      case KeeperWord::kTurnOff:
        if (!lit_) {
          reply(KeeperWord::kDark, message.request);
        } else {
          turn_off();
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
    poll_cover();
    if (lit_ || cover_contact_.on() || message.nanoseconds <= 0 || message.nanoseconds > kKeeperLongestNs) {
      reply(KeeperWord::kFailed, message.request);
      return;
    }
    if (!arm(0, message.nanoseconds)) {
      reply(KeeperWord::kFailed, message.request);
      return;
    }
    lit_ = line_.set(true);
    lit_request_ = message.request;
    if (!lit_) {
      static_cast<void>(line_.set(false));
      reply(KeeperWord::kFailed, message.request);
      return;
    }
    // Count the exposure from here. If this arming fails, the first one holds and the exposure is a little shorter.
    const std::int64_t on_at = now_ns();
    end_ = on_at + message.nanoseconds;
    static_cast<void>(arm(TFD_TIMER_ABSTIME, end_ - kSpinTime));
    send(KeeperWord::kLit, message.request, on_at);
  }

  bool arm(int flags, std::int64_t nanoseconds) const {
    itimerspec deadline{};
    deadline.it_value.tv_sec = static_cast<time_t>(nanoseconds / 1'000'000'000);
    deadline.it_value.tv_nsec = static_cast<long>(nanoseconds % 1'000'000'000);
    return ::timerfd_settime(timer_, flags, &deadline, nullptr) == 0;
  }

  void on_cover_edge(bool open, Contact::Time at) {
    if (!cover_contact_.update(open, at)) return;
    if (lit_) {
      // Line off first. Then send the reason, then "dark".
      stuck_ = !line_.set(false);
      report_cover(at.count());
      turn_off();
    } else {
      report_cover(at.count());
    }
  }

  void report_cover(std::int64_t at) const {
    if (cover_ != nullptr) send(cover_contact_.on() ? KeeperWord::kCoverOpened : KeeperWord::kCoverClosed, 0, at);
  }

  void reply(KeeperWord word, std::uint64_t request) const { send(word, request, now_ns()); }

  void send(KeeperWord word, std::uint64_t request, std::int64_t at) const {
    KeeperMessage message;
    message.word = word;
    message.request = request;
    message.nanoseconds = at;
    // A send that fails needs no handling: the end of the socket shows that the firmware is gone.
    static_cast<void>(::send(socket_, &message, sizeof message, MSG_DONTWAIT | MSG_NOSIGNAL));
  }

  LampLine& line_;
  CoverLine* cover_;
  int socket_;
  int timer_;
  Contact cover_contact_;
  bool lit_ = false;
  bool stuck_ = false;
  std::int64_t end_ = 0;  ///< of the exposure, CLOCK_MONOTONIC, ns
  std::uint64_t lit_request_ = 0;
};

}  // namespace

int keep_lamp(LampLine& line, CoverLine* cover, int socket, int firmware) {
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) ::sigaddset(&signals, number);
  ::sigprocmask(SIG_BLOCK, &signals, nullptr);
  const int signal_file = ::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
  const int timer = ::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
  // By number: C libraries older than Debian 12's lack the function.
  const int process = static_cast<int>(::syscall(SYS_pidfd_open, firmware, 0));
  if (signal_file < 0 || timer < 0 || process < 0) return 1;

  Keeper keeper(line, cover, socket, timer);
  bool serving = true;
  while (serving) {
    // poll() ignores negative descriptors and always reports hang-ups.
    std::array<pollfd, 5> fds = {{{socket, POLLIN, 0},
                                  {timer, POLLIN, 0},
                                  {process, POLLIN, 0},
                                  {signal_file, POLLIN, 0},
                                  {cover == nullptr ? -1 : cover->descriptor(), POLLIN, 0}}};
    if (::poll(fds.data(), fds.size(), keeper.wait_ms()) < 0 && errno != EINTR) break;
    if (keeper.stuck()) keeper.turn_off();
    keeper.poll_cover();
    std::uint64_t times = 0;
    if (::read(timer, &times, sizeof times) == sizeof times) keeper.end_exposure();
    if ((fds[2].revents | fds[3].revents) != 0) serving = false;
    if (fds[0].revents != 0 && !keeper.receive()) serving = false;
  }
  keeper.turn_off();
  // If the line still refuses, retry for about 1 s: the firmware is gone, so nothing else turns it off.
  for (int tries = 0; tries < 1000 && !line.set(false); ++tries) ::usleep(1000);
  for (const int fd : {signal_file, timer, process}) ::close(fd);
  return 0;
}

}  // namespace plumbline
