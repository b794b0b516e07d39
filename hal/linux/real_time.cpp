#include "hal/linux/real_time.hpp"

#include <sched.h>
#include <sys/mman.h>

namespace plumbline {

bool run_first(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return ::sched_setscheduler(0, SCHED_FIFO, &parameters) == 0;
}

bool lock_memory() { return ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0; }

}  // namespace plumbline
