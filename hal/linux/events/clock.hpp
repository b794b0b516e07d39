#pragma once
/// The board's monotonic clock.

#include "hal/clock.hpp"

namespace plumbline::inline hal::inline linux_board {

/// CLOCK_MONOTONIC, which the kernel also uses for GPIO edges and the keeper for its messages.
nanoseconds monotonic_now();

/// Returns at `deadline` or just after; signals don't interrupt it.
void sleep_until_monotonic(nanoseconds deadline);

class LinuxClock final : public Clock {
 private:
  TimePoint do_now() const override { return TimePoint(monotonic_now()); }
  Status do_sleep_until(TimePoint deadline) override;
};

}  // namespace plumbline::inline hal::inline linux_board
