#pragma once
/// A device that causes events.

#include <chrono>
#include <optional>

namespace plumbline::inline hal::inline linux_board {

class EventSource {
 public:
  EventSource() = default;
  EventSource(const EventSource&) = delete;
  EventSource& operator=(const EventSource&) = delete;
  virtual ~EventSource() = default;

  /// For poll(): readable when drain() has something to do; -1: none.
  virtual int descriptor() const = 0;
  /// When drain() must be called even if the descriptor is not readable, CLOCK_MONOTONIC; nothing: no need.
  virtual std::optional<std::chrono::nanoseconds> due() const { return std::nullopt; }
  /// Moves pending events to the machine's queue. Never waits.
  virtual void drain(std::chrono::nanoseconds now) = 0;
};

}  // namespace plumbline::inline hal::inline linux_board
