#pragma once
/// The machine's clock.

#include <chrono>

#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

/// The machine's time scale. Its zero is arbitrary, it never jumps, and it doesn't survive a restart.
struct MachineTime {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<MachineTime, duration>;
  static constexpr bool is_steady = true;  // NOLINT(readability-identifier-naming): std::chrono's name
};
using TimePoint = MachineTime::time_point;
using std::chrono::nanoseconds;

/// The firmware's only source of time. In simulation, time is virtual: it passes during device calls, and computing takes as
/// long as the simulation's settings say (hal/sim/README.md).
class Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;
  virtual ~Clock() = default;

  TimePoint now() const { return do_now(); }

  /// Returns at `deadline` or just after; at once if it has passed. Nothing interrupts it: to handle events while waiting, use
  /// Events::next_event().
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status sleep_until(TimePoint deadline) { return do_sleep_until(deadline); }

 private:
  virtual TimePoint do_now() const = 0;
  virtual Status do_sleep_until(TimePoint deadline) = 0;
};

}  // namespace plumbline::inline hal
