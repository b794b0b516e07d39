#pragma once
/// Virtual time: what is due happens in order, and nothing waits unless a pace was asked for.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "hal/clock.hpp"

namespace plumbline {

/// How virtual time goes with the host's.
struct Pace {
  /// Virtual seconds a host second: 1 is real time, 10 ten times as fast. 0: as fast as the host can.
  double speedup = 0;
  /// Virtual seconds that pass while the firmware computes for a host second. 0: computing takes no time, and a run is
  /// the same every time. 1: as slow as this host; 20: as a board a twentieth as fast.
  double computing = 0;
};

class Timeline {
 public:
  using Action = std::function<void()>;
  /// Names something that is due. Default-constructed: nothing.
  using Due = std::pair<TimePoint, std::uint64_t>;

  explicit Timeline(const Pace& pace) : pace_(pace) {}

  TimePoint now() const { return now_; }

  /// `action` happens at `time`, or now where that has passed; what is due at the same time happens in the order asked for.
  Due at(TimePoint time, Action action);
  void cancel(const Due& due) { due_.erase(due); }

  /// Lets time pass until `time`, or until `enough` says so, which is asked after everything that happened.
  /// Not to be called by an action.
  template <class Enough>
  void advance_until(TimePoint time, Enough&& enough) {
    while (!enough()) {
      if (!step(time)) return;
    }
  }

  /// Begin and end of a call of the firmware's: between an end and the next begin it computed.
  void enter_call();
  void leave_call();

 private:
  using HostClock = std::chrono::steady_clock;

  /// Lets the next thing happen that is due until `time`. @returns false: there was none, and it is `time` now
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

}  // namespace plumbline
