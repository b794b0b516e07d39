#pragma once
/// The wires of a stage: the stepper driver's and the end stop's.

#include <chrono>
#include <optional>

namespace plumbline::inline hal::inline linux_board {

/// Levels are logical. One thread at a time may use it, except for pressed(), which any thread may call.
class StageLines {
 public:
  struct Edge {
    bool pressed = false;
    std::chrono::nanoseconds at{};  ///< CLOCK_MONOTONIC
  };

  StageLines() = default;
  StageLines(const StageLines&) = delete;
  StageLines& operator=(const StageLines&) = delete;
  virtual ~StageLines() = default;

  /// Lets the driver hold the motor. This and the next two return false if a line could not be set.
  virtual bool enable(bool on) noexcept = 0;
  virtual bool set_direction(bool up) noexcept = 0;
  /// Sends one pulse, which is a microstep.
  virtual bool step() noexcept = 0;

  /// The end stop's present state. One that can't be read counts as pressed, so that nothing moves towards it.
  virtual bool pressed() const noexcept = 0;
  /// The oldest unread change of the end stop, including bounces.
  virtual std::optional<Edge> next_edge() noexcept = 0;
};

}  // namespace plumbline::inline hal::inline linux_board
