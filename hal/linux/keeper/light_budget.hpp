#pragma once
/// How much light the keeper gives.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>

namespace plumbline {

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
    // What a longer exposure would no longer touch, a shorter one after it may.
    const auto past =
        std::remove_if(exposures_.begin(), end(), [&](const Lit& one) { return one.until <= now - kMinute; });
    count_ = static_cast<std::size_t>(past - exposures_.begin());
    const Time from = now + cure - kMinute;
    Time light = std::min(cure, kMinute);
    for (auto one = exposures_.begin(); one != end(); ++one) {
      light += std::max(one->until - std::max(one->from, from), Time());
    }
    return light <= limits_.per_minute && count_ < exposures_.size();
  }

  /// Records an exposure. @pre allows() was true before it
  void add(Time from, Time until) { exposures_[count_++] = {from, until}; }

 private:
  struct Lit {
    Time from;
    Time until;
  };
  // Exposures of the shortest time that a board file allows, 0.1 s, would be 600 in a minute.
  using Exposures = std::array<Lit, 1024>;

  Exposures::iterator end() { return exposures_.begin() + static_cast<std::ptrdiff_t>(count_); }

  Exposures exposures_{};  // oldest first
  std::size_t count_ = 0;
  LightLimits limits_;
};

}  // namespace plumbline
