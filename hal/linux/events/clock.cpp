#include "hal/linux/events/clock.hpp"

#include <cerrno>
#include <ctime>

namespace plumbline::inline hal::inline linux_board {

nanoseconds monotonic_now() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::chrono::seconds(now.tv_sec) + nanoseconds(now.tv_nsec);
}

void sleep_until_monotonic(nanoseconds deadline) {
  if (deadline <= nanoseconds::zero()) return;
  timespec until{};
  until.tv_sec = static_cast<time_t>(deadline.count() / 1'000'000'000);
  until.tv_nsec = static_cast<long>(deadline.count() % 1'000'000'000);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

Status LinuxClock::do_sleep_until(TimePoint deadline) {
  sleep_until_monotonic(deadline.time_since_epoch());
  return {};
}

}  // namespace plumbline::inline hal::inline linux_board
