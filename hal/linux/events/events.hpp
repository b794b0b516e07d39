#pragma once
/// Waits for events of all devices of a board.

#include <array>
#include <span>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/event_source.hpp"

namespace plumbline::inline hal::inline linux_board {

class LinuxEvents final : public Events {
 public:
  static constexpr std::size_t kMaxSources =
      16;  ///< a board has at most 8: lamp, stage, panel, 3 buttons, stick, shutdown

  explicit LinuxEvents(EventQueue& queue) : queue_(queue) {}

  /// @pre fewer than kMaxSources were added
  void add(EventSource& source);
  /// Drops all events so far: the state in which a device is opened is no event.
  void discard_pending();

 private:
  Expected<std::optional<Event>> do_next_event(TimePoint deadline) override;
  void drain();

  EventQueue& queue_;
  std::array<EventSource*, kMaxSources> sources_{};
  std::size_t count_ = 0;
};

}  // namespace plumbline::inline hal::inline linux_board
