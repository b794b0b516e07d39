#pragma once
/// The wire that turns the lamp on, held by the keeper.

namespace plumbline::inline hal::inline linux_board {

/// Levels are logical; the line knows which voltage lights the lamp. Off when constructed and when destroyed.
class LampLine {
 public:
  LampLine() = default;
  LampLine(const LampLine&) = delete;
  LampLine& operator=(const LampLine&) = delete;
  virtual ~LampLine() = default;

  /// @returns false if the line could not be set
  virtual bool set(bool lit) noexcept = 0;
};

}  // namespace plumbline::inline hal::inline linux_board
