#pragma once
/// Waits for all devices of a board at once.

#include <array>
#include <span>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/event_source.hpp"

namespace plumbline {

class LinuxEvents final : public Events {
 public:
  static constexpr std::size_t kMostSources = 16;

  explicit LinuxEvents(EventQueue& queue) : queue_(queue) {}

  /// @pre fewer than kMostSources were added
  void add(EventSource& source);
  /// Nobody asked for what has happened until now: what a device finds when it is opened is no event.
  void forget();

 private:
  Expected<std::optional<Event>> do_next_event(TimePoint deadline) override;
  void drain();

  EventQueue& queue_;
  std::array<EventSource*, kMostSources> sources_{};
  std::size_t count_ = 0;
};

}  // namespace plumbline
