#pragma once
/// The system's wish to end the program, as an event.

#include <csignal>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/event_source.hpp"

namespace plumbline {

/// Takes SIGTERM out of the program's hands while it lives: it becomes EventKind::kShutdownRequested, which a print ends in order.
/// Made before the threads that are to leave it alone. SIGINT stays what it was.
class ShutdownSignal final : public EventSource {
 public:
  explicit ShutdownSignal(EventQueue& events);
  ~ShutdownSignal() override;

  int descriptor() const override { return file_; }
  void drain(std::chrono::nanoseconds now) override;

 private:
  EventQueue& events_;
  sigset_t former_{};
  int file_ = -1;
};

}  // namespace plumbline
