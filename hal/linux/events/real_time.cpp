#include "hal/linux/events/real_time.hpp"

#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>

#include <cstdlib>
#include <limits>

namespace plumbline {

bool set_real_time_priority(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return ::sched_setscheduler(0, SCHED_FIFO, &parameters) == 0;
}

bool lock_memory(Untouched untouched) {
  return ::mlockall(MCL_CURRENT | MCL_FUTURE | (untouched == Untouched::kLeave ? MCL_ONFAULT : 0)) == 0;
}

void reserve_heap() {
  // libusb, sysfs and mount(2) need some 10 KiB for a stick, which the heap would otherwise request from the kernel bit by bit.
  constexpr std::size_t kReserve = std::size_t{1} << 20;  // a hundred times that, and small for a board
  ::mallopt(M_ARENA_MAX, 1);
  ::mallopt(M_MMAP_MAX, 0);
  ::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  // volatile: otherwise the compiler may remove the unused allocation.
  void* volatile reserve = std::malloc(kReserve);
  std::free(reserve);
}

}  // namespace plumbline
