#pragma once
/// The machine's time.

#include <chrono>

#include "slicer/core/error.hpp"

namespace plumbline {

/// Tag of the machine's time line. It starts at an unknown moment, never jumps, and does not survive a restart.
struct MachineTime {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<MachineTime, duration>;
  static constexpr bool is_steady = true;  // NOLINT(readability-identifier-naming): std::chrono's name
};
using TimePoint = MachineTime::time_point;
using std::chrono::nanoseconds;

/// The only source of time for the firmware: what it measures, it measures here. In simulation time is virtual: it passes in
/// the calls of devices, and computing takes what the simulation was told (hal/sim/README.md).
class Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;
  virtual ~Clock() = default;

  TimePoint now() const { return do_now(); }

  /// Returns at `deadline` or just after it; at once where it has passed. Nothing interrupts it: a wait in which something may
  /// happen is Events::next_event().
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status sleep_until(TimePoint deadline) { return do_sleep_until(deadline); }

 private:
  virtual TimePoint do_now() const = 0;
  virtual Status do_sleep_until(TimePoint deadline) = 0;
};

}  // namespace plumbline
