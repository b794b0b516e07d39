#pragma once
/// Events of all devices, in the order in which they happened.

#include <algorithm>
#include <array>
#include <optional>

#include "hal/events.hpp"

namespace plumbline {

/// A fixed room. Devices tell of things a little after they happened, so a new event may belong before one that is waiting.
class EventQueue {
 public:
  static constexpr std::size_t kRoom = 256;

  /// A full queue loses the newest event: what is lost is a button's, which no one waited for through 255 others.
  void add(EventKind kind, std::chrono::nanoseconds at) {
    if (count_ == kRoom) return;
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
  std::array<Event, kRoom> events_{};
  std::size_t count_ = 0;
};

}  // namespace plumbline
