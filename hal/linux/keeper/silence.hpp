#pragma once
/// How firmware and keeper notice that the other one has stopped.

#include <chrono>

namespace plumbline::inline hal::inline linux_board {

/// How often the firmware pings the keeper, and after how many ticks without a word each of them acts.
struct WatchPace {
  std::chrono::nanoseconds tick;
  int patience;
};

/// While the lamp is lit: noticed after 25 to 30 ms. That leaves 20 ms of the 50 ms to end the other process and take the line.
inline constexpr WatchPace kLitPace{std::chrono::milliseconds(5), 5};
/// While it is dark nothing burns, and a board that slices with all its cores may be slow: noticed after about a second.
inline constexpr WatchPace kDarkPace{std::chrono::milliseconds(250), 4};

/// Counts the other one's silence in ticks, not in time. A tick that comes late counts once, so a board that stood still as a whole
/// blames nobody.
class Silence {
 public:
  using Time = std::chrono::nanoseconds;  ///< CLOCK_MONOTONIC

  void begin(WatchPace pace, Time now) {
    pace_ = pace;
    due_ = now + pace.tick;
    ticks_ = 0;
    heard_ = true;
  }
  void heard() { heard_ = true; }

  /// When tick() must be called.
  Time due() const { return due_; }
  void tick(Time now) {
    ticks_ = heard_ ? 0 : ticks_ + 1;
    heard_ = false;
    due_ = now + pace_.tick;
  }
  /// Whether the last tick found that the other one had spoken since the one before.
  bool well() const { return ticks_ == 0; }
  bool too_long() const { return ticks_ >= pace_.patience; }
  /// The silence that it takes.
  static constexpr Time limit(WatchPace pace) { return pace.tick * pace.patience; }

 private:
  WatchPace pace_ = kDarkPace;
  Time due_{};
  int ticks_ = 0;
  bool heard_ = false;
};

}  // namespace plumbline::inline hal::inline linux_board
