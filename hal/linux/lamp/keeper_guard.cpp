#include "hal/linux/lamp/keeper_guard.hpp"

#include <poll.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <utility>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/events/real_time.hpp"
#include "hal/linux/keeper/keeper_lines.hpp"
#include "hal/linux/keeper/keeper_protocol.hpp"
#include "hal/linux/keeper/silence.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

using std::chrono::milliseconds;

/// Puts this thread and another process on one processor. If that one stands still for a while, neither blames the other; both run
/// before all else on it.
void share_processor_with(pid_t process) {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(::sched_getcpu(), &one);
  for (const pid_t which : {0, process}) static_cast<void>(::sched_setaffinity(which, sizeof one, &one));
}

}  // namespace

KeeperGuard::KeeperGuard(pid_t keeper, int socket, std::string line)
    : keeper_(keeper),
      process_(keeper),
      socket_(socket),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      line_(std::move(line)) {
  // Before the thread runs: the keeper gives no light to a firmware that does not watch it.
  ping();
  thread_ = std::thread([this] { run(); });
}

KeeperGuard::~KeeperGuard() {
  quit_ = true;
  wake();
  thread_.join();
  for (const int fd : {socket_, wake_}) {
    if (fd >= 0) ::close(fd);
  }
}

void KeeperGuard::wake() const {
  const std::uint64_t one = 1;
  static_cast<void>(::write(wake_, &one, sizeof one));  // fails only if it is already readable
}

void KeeperGuard::watch_closely(bool closely) {
  if (closely_.exchange(closely) != closely) wake();
}

void KeeperGuard::give_up() {
  given_up_ = true;
  wake();
}

bool KeeperGuard::await_dark(milliseconds time) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, time, [this] { return dark_; });
}

void KeeperGuard::ping() {
  // A keeper that does not read fills the socket, and is found to be silent anyway.
  static_cast<void>(::send(socket_, &++pings_, sizeof pings_, MSG_DONTWAIT | MSG_NOSIGNAL));
}

void KeeperGuard::run() {
  if (set_real_time_priority(kKeeperPriority)) share_processor_with(keeper_);
  watch();
  take_line();
}

void KeeperGuard::watch() {
  Silence silence;
  bool closely = false;
  int socket = socket_;
  silence.begin(kDarkPace, monotonic_now());
  for (;;) {
    if (closely_ != closely) {
      closely = !closely;
      silence.begin(closely ? kLitPace : kDarkPace, monotonic_now());
      ping();
    }
    std::array<pollfd, 3> fds = {{{socket, POLLIN, 0}, {process_.descriptor(), POLLIN, 0}, {wake_, POLLIN, 0}}};
    const auto wait = std::max(silence.due() - monotonic_now(), nanoseconds::zero());
    timespec time{};
    time.tv_nsec = static_cast<long>(wait.count());  // a tick is below 1 s
    static_cast<void>(::ppoll(fds.data(), fds.size(), &time, nullptr));
    if (fds[1].revents != 0) return;
    if (given_up_) break;
    // The keeper is ending. A closed socket stays readable, and this thread must not keep the processor from the keeper.
    if ((fds[0].revents & POLLHUP) != 0) socket = -1;
    std::uint64_t count = 0;
    static_cast<void>(::read(wake_, &count, sizeof count));
    KeeperPing pong = 0;
    while (::recv(socket_, &pong, sizeof pong, MSG_DONTWAIT) == sizeof pong) silence.heard();
    const auto now = monotonic_now();
    if (now < silence.due()) continue;
    silence.tick(now);
    if (silence.too_long()) break;
    ping();
  }
  reason_ = "did not answer";
  process_.kill();
}

void KeeperGuard::take_line() {
  while (!process_.await_end(milliseconds(1000)) && !quit_) {
  }
  siginfo_t end{};
  const bool reaped =
      ::waitid(P_PID, static_cast<id_t>(keeper_), &end, WEXITED | WNOHANG) == 0 && end.si_pid == keeper_;
  const bool in_order = expected_ && reaped && end.si_code == CLD_EXITED && end.si_status == 0;
  // A process in the kernel's hands may keep the line for a while. Nothing else turns it off, so try until it works.
  for (int tries = 0; !in_order; ++tries) {
    auto line = open_lamp_line(line_);
    if (line && (*line)->set(false)) {
      held_ = std::move(*line);
      break;
    }
    constexpr int kLastTries = 1000;
    if (quit_ && tries >= kLastTries) return;
    static_cast<void>(::usleep(1000));
  }
  {
    const std::scoped_lock lock(mutex_);
    dark_ = true;
  }
  changed_.notify_all();
}

}  // namespace plumbline::inline hal::inline linux_board
