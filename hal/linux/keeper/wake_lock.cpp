#include "hal/linux/keeper/wake_lock.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>

namespace plumbline::inline hal::inline linux_board {

WakeLock::WakeLock() : event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)), waits_(::epoll_create1(EPOLL_CLOEXEC)) {
  epoll_event event{};
  event.events = EPOLLIN | EPOLLWAKEUP;
  static_cast<void>(::epoll_ctl(waits_, EPOLL_CTL_ADD, event_, &event));
}

WakeLock::~WakeLock() {
  if (waits_ >= 0) ::close(waits_);
  if (event_ >= 0) ::close(event_);
}

void WakeLock::hold() noexcept {
  const std::uint64_t one = 1;
  static_cast<void>(::write(event_, &one, sizeof one));
}

void WakeLock::release() noexcept {
  std::uint64_t count = 0;
  epoll_event event{};
  // The kernel counts an event as handled when the next wait begins.
  if (::read(event_, &count, sizeof count) > 0) static_cast<void>(::epoll_wait(waits_, &event, 1, 0));
}

}  // namespace plumbline::inline hal::inline linux_board
