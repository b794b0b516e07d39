#pragma once
/// Virtual time: due actions run in order, without waiting unless a pace is set.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "hal/clock.hpp"

namespace plumbline::inline hal::inline sim {

/// How virtual time relates to the host's.
struct Pace {
  /// Virtual seconds per host second: 1 is real time, 10 is ten times as fast. 0: as fast as the host can.
  double speedup = 0;
  /// Virtual seconds per host second that the firmware computes. 0: computing takes no time and every run is the same; 1: as fast as
  /// this host; 20: as slow as a board a twentieth as fast.
  double computing = 0;
};

class Timeline {
 public:
  using Action = std::function<void()>;
  /// Identifies a scheduled action. Default-constructed: none.
  using Due = std::pair<TimePoint, std::uint64_t>;

  explicit Timeline(const Pace& pace) : pace_(pace) {}

  TimePoint now() const { return now_; }

  /// Schedules `action` at `time`, or now if that has passed. Actions due at the same time run in the order of scheduling.
  Due at(TimePoint time, Action action);
  void cancel(const Due& due) { due_.erase(due); }

  /// Lets time pass until `time`, or until `enough` returns true; it is checked after each action. Actions must not call this.
  template <class Enough>
  void advance_until(TimePoint time, Enough&& enough) {
    while (!enough()) {
      if (!step(time)) return;
    }
  }

  /// Begin and end of a device call. Between a call's end and the next begin the firmware computes.
  void enter_call();
  void leave_call();

 private:
  using HostClock = std::chrono::steady_clock;

  /// Runs the next action due until `time`. @returns false if there was none; then it is `time` now
  bool step(TimePoint time);
  void set_now(TimePoint time);

  Pace pace_;
  TimePoint now_;
  std::uint64_t order_ = 0;
  std::map<Due, Action> due_;
  HostClock::time_point host_start_ = HostClock::now();
  HostClock::time_point left_at_ = host_start_;
  int depth_ = 0;
};

}  // namespace plumbline::inline hal::inline sim
