#include "hal/linux/keeper/keeper.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/gpio/contact.hpp"
#include "hal/linux/gpio/edges.hpp"
#include "hal/linux/keeper/keeper_protocol.hpp"
#include "hal/linux/keeper/process_handle.hpp"
#include "hal/linux/keeper/silence.hpp"
#include "hal/linux/keeper/wake_lock.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

/// The timer fires this long before an exposure's end; from there the keeper spins. A scheduler may wake a process late, on a slow
/// board by up to 1 ms. A longer spin catches more of that and costs a core for longer in each layer.
constexpr nanoseconds kSpinTime = std::chrono::microseconds(500);

class Keeper {
 public:
  Keeper(const KeeperDuty& duty, int timer)
      : line_(duty.line),
        cover_(duty.cover),
        watchdog_(duty.watchdog),
        socket_(duty.socket),
        watch_socket_(duty.watch_socket),
        timer_(timer),
        cover_contact_(cover_ != nullptr && cover_->open()),
        budget_(duty.limits) {
    const nanoseconds now = monotonic_now();
    if (duty.lit_before > nanoseconds()) budget_.add(now - duty.lit_before, now);
    report_cover(now);
    silence_.begin(kDarkPace, now);
  }

  void turn_off() {
    stuck_ = !line_.set(false);
    if (stuck_ || !lit_) return;
    const nanoseconds now = monotonic_now();
    lit_ = false;
    send(KeeperWord::kDark, lit_request_, now);
    budget_.add(lit_at_, now);
    silence_.begin(kDarkPace, now);
    wake_lock_.release();
  }

  /// Called when the timer has fired.
  void end_exposure() {
    while (lit_ && monotonic_now() < end_) {
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
    const nanoseconds now = monotonic_now();
    on_cover_edge(cover_->open(), now);
    if (const auto closed = cover_contact_.settle(now)) report_cover(*closed);
  }

  /// How long to wait for descriptors: until the next retry, until the cover's contact has settled, or until the next look at the
  /// firmware.
  timespec wait() const {
    constexpr nanoseconds kRetry = std::chrono::milliseconds(1);
    const nanoseconds due = std::min(silence_.due(), cover_contact_.due().value_or(nanoseconds::max()));
    const nanoseconds wait = stuck_ ? kRetry : std::max(due - monotonic_now(), nanoseconds());
    timespec time{};
    time.tv_nsec = static_cast<long>(wait.count());  // a tick is below 1 s
    return time;
  }

  /// Answers pings, counts the firmware's silence and feeds the watchdog.
  void watch_firmware() {
    KeeperPing ping = 0;
    while (::recv(watch_socket_, &ping, sizeof ping, MSG_DONTWAIT) == sizeof ping) {
      static_cast<void>(::send(watch_socket_, &ping, sizeof ping, MSG_DONTWAIT | MSG_NOSIGNAL));
      silence_.heard();
      if (!met_) silence_.begin(kDarkPace, monotonic_now());
      met_ = true;
    }
    const nanoseconds now = monotonic_now();
    if (now < silence_.due()) return;
    silence_.tick(now);
    if (watchdog_ == nullptr || !silence_.well() || now - fed_at_ < Watchdog::kFeedEvery) return;
    fed_at_ = now;
    watchdog_->feed();
  }

  /// Only a firmware that has pinged before can fall silent: it starts the keeper, then watches it.
  bool firmware_is_silent() const { return met_ && silence_.too_long(); }
  bool told_to_end() const { return told_to_end_; }

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
      case KeeperWord::kEnd: told_to_end_ = true; return false;
      case KeeperWord::kLit:
      case KeeperWord::kDark:
      case KeeperWord::kFailed:
      case KeeperWord::kRefused:
      case KeeperWord::kCoverOpened:
      case KeeperWord::kCoverClosed: return false;
    }
    return false;
  }

 private:
  void light(const KeeperMessage& message) {
    poll_cover();
    if (lit_ || cover_contact_.on()) return reply(KeeperWord::kFailed, message.request);
    const nanoseconds cure(message.nanoseconds);
    if (!budget_.allows(monotonic_now(), cure)) return reply(KeeperWord::kRefused, message.request);
    // A firmware that does not watch the keeper gets no light.
    if (!met_ || !arm(0, cure)) return reply(KeeperWord::kFailed, message.request);
    wake_lock_.hold();
    lit_ = line_.set(true);
    lit_request_ = message.request;
    if (!lit_) {
      static_cast<void>(line_.set(false));
      wake_lock_.release();
      return reply(KeeperWord::kFailed, message.request);
    }
    // Count the exposure from here. If this arming fails, the first one holds and the exposure is a little shorter.
    lit_at_ = monotonic_now();
    end_ = lit_at_ + cure;
    static_cast<void>(arm(TFD_TIMER_ABSTIME, end_ - kSpinTime));
    silence_.begin(kLitPace, lit_at_);
    send(KeeperWord::kLit, message.request, lit_at_);
  }

  bool arm(int flags, nanoseconds time) const {
    itimerspec deadline{};
    deadline.it_value.tv_sec = static_cast<time_t>(time.count() / 1'000'000'000);
    deadline.it_value.tv_nsec = static_cast<long>(time.count() % 1'000'000'000);
    return ::timerfd_settime(timer_, flags, &deadline, nullptr) == 0;
  }

  void on_cover_edge(bool open, nanoseconds at) {
    if (!cover_contact_.update(open, at)) return;
    // Line off first. Then send the reason, then "dark".
    if (lit_) stuck_ = !line_.set(false);
    report_cover(at);
    if (lit_) turn_off();
  }

  void report_cover(nanoseconds at) const {
    if (cover_ != nullptr) send(cover_contact_.on() ? KeeperWord::kCoverOpened : KeeperWord::kCoverClosed, 0, at);
  }

  void reply(KeeperWord word, std::uint64_t request) const { send(word, request, monotonic_now()); }

  void send(KeeperWord word, std::uint64_t request, nanoseconds at) const {
    KeeperMessage message;
    message.word = word;
    message.request = request;
    message.nanoseconds = at.count();
    // A send that fails needs no handling: the end of the socket shows that the firmware is gone.
    static_cast<void>(::send(socket_, &message, sizeof message, MSG_DONTWAIT | MSG_NOSIGNAL));
  }

  LampLine& line_;
  CoverLine* cover_;
  Watchdog* watchdog_;
  int socket_;
  int watch_socket_;
  int timer_;
  Contact cover_contact_;
  LightBudget budget_;
  WakeLock wake_lock_;
  Silence silence_;   ///< of the firmware
  bool met_ = false;  ///< the firmware has pinged
  bool told_to_end_ = false;
  // Times are those of monotonic_now().
  nanoseconds fed_at_{};
  bool lit_ = false;
  bool stuck_ = false;
  nanoseconds lit_at_{};
  nanoseconds end_{};  ///< of the exposure
  std::uint64_t lit_request_ = 0;
};

}  // namespace

int keep_lamp(const KeeperDuty& duty) {
  // The kernel continues a keeper that is stopped when its firmware dies, so that it can turn the line off.
  ::prctl(PR_SET_PDEATHSIG, SIGCONT);
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) ::sigaddset(&signals, number);
  ::sigprocmask(SIG_BLOCK, &signals, nullptr);
  const int signal_file = ::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
  const int timer = ::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
  const ProcessHandle firmware(duty.firmware);
  // If it is not our parent, the firmware died before the handle was made, and its process ID may now belong to another process.
  if (signal_file < 0 || timer < 0 || !firmware.ok() || ::getppid() != duty.firmware) return 1;

  Keeper keeper(duty, timer);
  bool serving = true;
  while (serving && !keeper.firmware_is_silent()) {
    // ppoll() ignores negative descriptors and always reports hang-ups.
    std::array<pollfd, 6> fds = {{{duty.socket, POLLIN, 0},
                                  {timer, POLLIN, 0},
                                  {firmware.descriptor(), POLLIN, 0},
                                  {signal_file, POLLIN, 0},
                                  {duty.watch_socket, POLLIN, 0},
                                  {duty.cover == nullptr ? -1 : duty.cover->descriptor(), POLLIN, 0}}};
    const timespec wait = keeper.wait();
    if (::ppoll(fds.data(), fds.size(), &wait, nullptr) < 0 && errno != EINTR) break;
    if (keeper.stuck()) keeper.turn_off();
    keeper.poll_cover();
    std::uint64_t times = 0;
    if (::read(timer, &times, sizeof times) == sizeof times) keeper.end_exposure();
    keeper.watch_firmware();
    if ((fds[2].revents | fds[3].revents | (fds[4].revents & POLLHUP)) != 0) serving = false;
    if (fds[0].revents != 0 && !keeper.receive()) serving = false;
  }
  const bool silent = keeper.firmware_is_silent();
  keeper.turn_off();
  if (silent) firmware.kill();
  // If the line still refuses, retry for about 1 s: the firmware is gone, so nothing else turns it off.
  bool dark = duty.line.set(false);
  for (int tries = 0; tries < 1000 && !dark; ++tries) {
    ::usleep(1000);
    dark = duty.line.set(false);
  }
  if (dark && keeper.told_to_end() && duty.watchdog != nullptr) duty.watchdog->disarm();
  if (silent) {
    std::fprintf(stderr,
                 "plumbline-keeper: the firmware did not answer: turned the lamp off and killed the firmware\n");
  }
  for (const int fd : {signal_file, timer}) ::close(fd);
  return 0;
}

}  // namespace plumbline::inline hal::inline linux_board
