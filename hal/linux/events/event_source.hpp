#pragma once
/// A device that has news of its own.

#include <chrono>
#include <optional>

namespace plumbline {

class EventSource {
 public:
  EventSource() = default;
  EventSource(const EventSource&) = delete;
  EventSource& operator=(const EventSource&) = delete;
  virtual ~EventSource() = default;

  /// Readable when there is news; -1: this device has none to wait for.
  virtual int descriptor() const = 0;
  /// When it is to be asked although its descriptor is silent; nothing: not at all. CLOCK_MONOTONIC.
  virtual std::optional<std::chrono::nanoseconds> due() const { return std::nullopt; }
  /// Puts its news into the machine's queue. Never waits.
  virtual void drain(std::chrono::nanoseconds now) = 0;
};

}  // namespace plumbline
