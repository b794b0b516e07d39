#include "hal/linux/events/real_time.hpp"

#include <sched.h>

namespace plumbline::inline hal::inline linux_board {

bool set_real_time_priority(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return ::sched_setscheduler(0, SCHED_FIFO, &parameters) == 0;
}

}  // namespace plumbline::inline hal::inline linux_board
