#pragma once
/// How well a real printer's Z stage kept its times.

#include <cstdint>

#include "hal/clock.hpp"

namespace plumbline::firmware {

struct StepFigures {
  std::uint64_t steps = 0;
  std::uint64_t late = 0;         ///< by more than 0.1 ms and more than half the time to the next step
  nanoseconds worst_lateness{};   ///< of one step
  std::uint64_t standstills = 0;  ///< so late that the motor had stopped; the rest of the move was a new ramp
  bool real_time = false;         ///< the stage's thread has real-time priority
  bool memory_locked = false;     ///< mlockall() succeeded
};

}  // namespace plumbline::firmware
