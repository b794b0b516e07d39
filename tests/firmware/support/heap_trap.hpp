#pragma once
/// Counts every allocation while it is armed.
///
/// The program's own malloc and relatives replace the C library's for everything linked into it. An allocation is
/// the simulated machine's when a function of plumbline::hal::sim is on the stack.

#include <cstddef>

namespace plumbline::firmware {

/// Allocations since the trap was armed.
struct HeapUse {
  int trapped = 0;    ///< blocks that nothing may take
  int simulator = 0;  ///< blocks
};

/// Armed from construction to destruction. One at a time.
class HeapTrap {
 public:
  HeapTrap();
  ~HeapTrap() { disarm(); }
  HeapTrap(const HeapTrap&) = delete;
  HeapTrap& operator=(const HeapTrap&) = delete;
  /// Harmless if already disarmed.
  HeapUse disarm();
  /// Prints to standard error where the first blocks were taken.
  static void print_stacks();
};

}  // namespace plumbline::firmware
