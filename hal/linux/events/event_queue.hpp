#pragma once
/// Events of all devices in the order in which they happened.

#include <algorithm>
#include <array>
#include <optional>

#include "hal/events.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Fixed capacity. Devices report with a delay, so a new event may be older than one that is already queued.
class EventQueue {
 public:
  static constexpr std::size_t kCapacity = 256;  ///< the firmware reads events as they come, so a few would do

  /// A full queue drops the new event: after 256 unread ones nobody misses a button press.
  void add(EventKind kind, std::chrono::nanoseconds at) {
    if (count_ == kCapacity) return;
    const Event event{TimePoint(at), kind};
    const auto end = events_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto place =
        std::upper_bound(events_.begin(), end, event, [](const Event& a, const Event& b) { return a.at < b.at; });
    std::move_backward(place, end, end + 1);
    *place = event;
    ++count_;
  }

  std::optional<Event> take() {
    if (count_ == 0) return std::nullopt;
    const Event first = events_.front();
    std::move(events_.begin() + 1, events_.begin() + static_cast<std::ptrdiff_t>(count_), events_.begin());
    --count_;
    return first;
  }

 private:
  std::array<Event, kCapacity> events_{};
  std::size_t count_ = 0;
};

}  // namespace plumbline::inline hal::inline linux_board
