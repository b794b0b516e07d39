#pragma once
/// The board's monotonic clock.

#include "hal/clock.hpp"

namespace plumbline {

/// CLOCK_MONOTONIC since its start: the time of lines' edges and of the keeper, too.
nanoseconds monotonic_now();

/// Returns at `deadline` or just after it; signals do not interrupt it.
void sleep_until_monotonic(nanoseconds deadline);

class LinuxClock final : public Clock {
 private:
  TimePoint do_now() const override { return TimePoint(monotonic_now()); }
  Status do_sleep_until(TimePoint deadline) override;
};

}  // namespace plumbline
