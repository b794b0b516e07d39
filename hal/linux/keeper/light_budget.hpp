#pragma once
/// How much light the lamp gives.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <span>

namespace plumbline::inline hal::inline linux_board {

/// From the board file. The keeper refuses more, whatever the firmware asks for.
struct LightLimits {
  std::chrono::nanoseconds longest{};     ///< of one exposure
  std::chrono::nanoseconds per_minute{};  ///< in any 60 s
};

/// Remembers when the lamp was lit in the last minute. Times are CLOCK_MONOTONIC.
class LightBudget {
 public:
  using Time = std::chrono::nanoseconds;
  static constexpr Time kMinute = std::chrono::seconds(60);

  explicit LightBudget(LightLimits limits) : limits_(limits) {}

  /// Whether an exposure that begins now keeps both limits. The minute that ends with the exposure has the most light of all that it
  /// touches.
  /// @pre the lamp is dark
  bool allows(Time now, Time cure) {
    if (cure <= Time() || cure > limits_.longest) return false;
    forget(now);
    const Time light = std::min(cure, kMinute) + light_since(now + cure - kMinute);
    return light <= limits_.per_minute && count_ < exposures_.size();
  }

  /// Records an exposure that has ended.
  void add(Time from, Time until) {
    forget(until);
    if (count_ < exposures_.size()) exposures_[count_++] = {from, until};
  }

  /// Light since a time in the last minute.
  Time light_since(Time from) const {
    Time light{};
    for (const Lit& one : std::span(exposures_).first(count_)) {
      light += std::max(one.until - std::max(one.from, from), Time());
    }
    return light;
  }

 private:
  struct Lit {
    Time from;
    Time until;
  };
  /// Exposures that ended over a minute ago: no later minute has any of their light.
  void forget(Time now) {
    const auto end = exposures_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto kept =
        std::remove_if(exposures_.begin(), end, [&](const Lit& one) { return one.until <= now - kMinute; });
    count_ = static_cast<std::size_t>(kept - exposures_.begin());
  }

  // Exposures of the shortest time that a board file allows, 0.1 s, would be 600 in a minute.
  std::array<Lit, 1024> exposures_{};  // oldest first
  std::size_t count_ = 0;
  LightLimits limits_;
};

}  // namespace plumbline::inline hal::inline linux_board
