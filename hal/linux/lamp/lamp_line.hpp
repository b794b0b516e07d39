#pragma once
/// The wire that turns the lamp on, as the keeper holds it.

namespace plumbline {

/// Logical levels: which voltage lights the lamp is the line's own knowledge. Off when it is made and when it ends.
class LampLine {
 public:
  LampLine() = default;
  LampLine(const LampLine&) = delete;
  LampLine& operator=(const LampLine&) = delete;
  virtual ~LampLine() = default;

  /// @returns false: the line could not be set
  virtual bool set(bool lit) noexcept = 0;
};

}  // namespace plumbline
