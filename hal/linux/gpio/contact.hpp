#pragma once
/// Debounces a switch.

#include <chrono>
#include <optional>
#include <utility>

namespace plumbline::inline hal::inline linux_board {

/// Accepts "on" at the first contact and "off" once the line has been off for kBounceTime: an opened cover and a pressed button
/// must not wait, and each must be reported once. Times are CLOCK_MONOTONIC.
class Contact {
 public:
  using Time = std::chrono::nanoseconds;
  static constexpr Time kBounceTime =
      std::chrono::milliseconds(30);  ///< longer rides out worse contacts, but delays "cover closed" and the next press

  /// @param on  initial state
  explicit Contact(bool on) : on_(on) {}

  /// The debounced state.
  bool on() const { return on_; }

  /// Takes a reading of the line made at `at`.
  /// @returns whether it has just gone on
  bool update(bool on, Time at) {
    if (on) {
      off_since_.reset();
      return !std::exchange(on_, true);
    }
    if (on_ && !off_since_) off_since_ = at;  // a bounce turns it on in between, which restarts the wait
    return false;
  }

  /// When to call settle(); nothing if the contact is at rest.
  std::optional<Time> due() const {
    if (!off_since_) return std::nullopt;
    return *off_since_ + kBounceTime;
  }

  /// Call it at due() or later.
  /// @returns when the contact went off, once, after it has been off for kBounceTime
  std::optional<Time> settle(Time now) {
    if (!off_since_ || now < *off_since_ + kBounceTime) return std::nullopt;
    on_ = false;
    return std::exchange(off_since_, std::nullopt);
  }

 private:
  bool on_;
  std::optional<Time> off_since_;
};

}  // namespace plumbline::inline hal::inline linux_board
