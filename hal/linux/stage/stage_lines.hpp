#pragma once
/// The wires of a stage: a step motor's driver and the end stop.

#include <chrono>
#include <optional>

namespace plumbline {

/// Logical levels. Used by one thread at a time, but for pressed(), which any may ask.
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

  /// The driver holds the motor. @returns false: the line could not be set; so below
  virtual bool enable(bool on) noexcept = 0;
  virtual bool set_direction(bool up) noexcept = 0;
  /// One pulse: a microstep.
  virtual bool step() noexcept = 0;

  /// The end stop as it is. One that can't be read counts as pressed: nothing moves towards it.
  virtual bool pressed() const noexcept = 0;
  /// The oldest change of the end stop that was not asked for yet; bounces included.
  virtual std::optional<Edge> next_edge() noexcept = 0;
};

}  // namespace plumbline
