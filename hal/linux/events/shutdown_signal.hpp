#pragma once
/// Turns SIGTERM into an event.

#include <csignal>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/event_source.hpp"

namespace plumbline::inline hal::inline linux_board {

/// While it lives, SIGTERM becomes EventKind::kShutdownRequested, so that a print can end in order. Make it before starting threads,
/// which inherit the blocked signal. SIGINT is unaffected.
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

}  // namespace plumbline::inline hal::inline linux_board
