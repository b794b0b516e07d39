#pragma once
/// Counts every allocation while it is armed.
///
/// The program's own malloc and relatives replace the C library's for everything linked into it. An allocation is lodepng's when
/// code of lodepng's shared library is on the stack, and the simulated machine's when a member of a plumbline::Sim... class is.

#include <cstddef>

namespace plumbline {

/// Allocations since the trap was armed.
struct HeapUse {
  int trapped = 0;                ///< blocks that nothing may take
  int lodepng = 0;                ///< blocks
  int simulator = 0;              ///< blocks
  std::size_t lodepng_live = 0;   ///< bytes not freed yet
  std::size_t lodepng_peak = 0;   ///< bytes
  bool lodepng_overflow = false;  ///< more blocks than the trap can track
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

}  // namespace plumbline
