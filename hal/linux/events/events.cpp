#include "hal/linux/events/events.hpp"

#include <poll.h>

#include <cassert>
#include <ctime>

#include "hal/linux/events/clock.hpp"

namespace plumbline::inline hal::inline linux_board {

void LinuxEvents::add(EventSource& source) {
  assert(count_ < kMaxSources);
  sources_[count_++] = &source;
}

void LinuxEvents::drain() {
  const auto now = monotonic_now();
  for (std::size_t i = 0; i < count_; ++i) sources_[i]->drain(now);
}

void LinuxEvents::discard_pending() {
  drain();
  while (queue_.take()) {
  }
}

Expected<std::optional<Event>> LinuxEvents::do_next_event(TimePoint deadline) {
  for (;;) {
    drain();
    if (const auto event = queue_.take()) return event;
    const auto now = monotonic_now();
    auto wake = deadline.time_since_epoch();
    if (now >= wake) return std::nullopt;
    std::array<pollfd, kMaxSources> fds{};
    for (std::size_t i = 0; i < count_; ++i) {
      fds[i] = {sources_[i]->descriptor(), POLLIN, 0};
      if (const auto due = sources_[i]->due()) wake = std::min(wake, *due);
    }
    const auto wait = std::max(wake - now, nanoseconds::zero());
    timespec time{};
    time.tv_sec = static_cast<time_t>(wait.count() / 1'000'000'000);
    time.tv_nsec = static_cast<long>(wait.count() % 1'000'000'000);
    // After a signal or a readable descriptor the loop starts over.
    static_cast<void>(::ppoll(fds.data(), count_, &time, nullptr));
  }
}

}  // namespace plumbline::inline hal::inline linux_board
