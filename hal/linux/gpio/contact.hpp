#pragma once
/// A switch whose contact bounces.

#include <chrono>
#include <optional>
#include <utility>

namespace plumbline {

/// Believes a contact that closes at once, and one that opens when it has stayed open for a while: the cover's opening and a
/// pressed button must not wait, and neither may come twice. Times are CLOCK_MONOTONIC.
class Contact {
 public:
  using Time = std::chrono::nanoseconds;
  static constexpr Time kQuiet = std::chrono::milliseconds(30);  ///< bouncing is over after it

  /// @param on  as it is found
  explicit Contact(bool on) : on_(on) {}

  /// As believed.
  bool on() const { return on_; }

  /// The line was seen so at `at`.
  /// @returns true: it has just gone on
  bool saw(bool on, Time at) {
    if (on) {
      off_since_.reset();
      const bool news = !on_;
      on_ = true;
      return news;
    }
    if (on_ && !off_since_) off_since_ = at;  // a bounce goes on in between, which starts the wait anew
    return false;
  }

  /// When settle() is to be called; nothing: there is nothing to wait for.
  std::optional<Time> due() const {
    if (!off_since_) return std::nullopt;
    return *off_since_ + kQuiet;
  }

  /// @returns when it went off, where it has been off for kQuiet and this was not said yet
  std::optional<Time> settle(Time now) {
    if (!off_since_ || now < *off_since_ + kQuiet) return std::nullopt;
    on_ = false;
    return std::exchange(off_since_, std::nullopt);
  }

 private:
  bool on_;
  std::optional<Time> off_since_;
};

}  // namespace plumbline
