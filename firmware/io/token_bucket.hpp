#pragma once
/// How often something may happen: requests of a client, lines of a log.

#include <algorithm>
#include <chrono>
#include <utility>

namespace plumbline::firmware {

/// So many at once, and so many a second in the long run. Whoever goes on asking in vain goes into debt, down to minus `burst`.
class TokenBucket {
 public:
  using HostClock = std::chrono::steady_clock;

  struct Size {
    double burst = 1;
    double a_second = 1;
  };

  constexpr explicit TokenBucket(const Size& size) : size_(size), level_(size.burst) {}

  /// @returns whether it is granted
  [[nodiscard]] bool take(HostClock::time_point now) {
    const double before = level(now);
    at_ = now;
    level_ = std::max(before - 1, -size_.burst);
    return before >= 1;
  }
  /// Whether so much was asked in vain that asking again need not even be read.
  bool in_debt(HostClock::time_point now) const { return level(now) < -size_.burst / 2; }
  /// How long until the next one is granted.
  HostClock::duration wait(HostClock::time_point now) const {
    const double missing = std::max(0.0, 1 - level(now));
    return std::chrono::duration_cast<HostClock::duration>(std::chrono::duration<double>(missing / size_.a_second));
  }

 private:
  double level(HostClock::time_point now) const {
    if (at_ == HostClock::time_point()) return size_.burst;
    return std::min(size_.burst, level_ + std::chrono::duration<double>(now - at_).count() * size_.a_second);
  }

  Size size_;
  double level_;
  HostClock::time_point at_{};  ///< of level_; the clock's start: it is full
};

/// A log that nobody can fill: lines beyond its bound are counted.
class LogBound {
 public:
  constexpr explicit LogBound(const TokenBucket::Size& lines) : lines_(lines) {}

  /// @returns whether a line is written
  [[nodiscard]] bool takes_line(TokenBucket::HostClock::time_point now) {
    // A log is never in debt: it goes on as soon as there is room.
    const bool is_free = lines_.wait(now) == TokenBucket::HostClock::duration::zero();
    if (is_free) return lines_.take(now);
    ++left_out_;
    return false;
  }
  /// How many lines were not written since the last call.
  unsigned take_left_out() { return std::exchange(left_out_, 0U); }

 private:
  TokenBucket lines_;
  unsigned left_out_ = 0;
};

}  // namespace plumbline::firmware
