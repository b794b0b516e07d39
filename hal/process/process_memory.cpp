#include "hal/process/process_memory.hpp"

#include <malloc.h>
#include <sys/mman.h>

#include <cstdlib>
#include <limits>

namespace plumbline::inline hal {

bool lock_memory(Untouched untouched) {
  return ::mlockall(MCL_CURRENT | MCL_FUTURE | (untouched == Untouched::kLeave ? MCL_ONFAULT : 0)) == 0;
}

void reserve_heap() {
  // libusb, sysfs and settings files need some 10 KiB, which the heap would otherwise request from the kernel bit by bit.
  constexpr std::size_t kReserve = std::size_t{1} << 20;  // a hundred times that, and small for a board
  ::mallopt(M_ARENA_MAX, 1);
  ::mallopt(M_MMAP_MAX, 0);
  ::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  // volatile: otherwise the compiler may remove the unused allocation.
  void* volatile reserve = std::malloc(kReserve);
  std::free(reserve);
}

}  // namespace plumbline::inline hal
