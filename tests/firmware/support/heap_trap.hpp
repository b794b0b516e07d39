#pragma once
/// Traps every block that anybody takes from the heap while it is armed.
///
/// The program has its own malloc and its relatives, in front of those of the C library: whoever is linked into it, statically
/// or not, calls these. A call is lodepng's when code of lodepng's shared library is on the stack, and the simulated machine's
/// when a member of a plumbline::Sim... class is: no board runs either of its own accord.

#include <cstddef>

namespace plumbline {

/// What has been taken since the last trap was armed.
struct HeapUse {
  int trapped = 0;                ///< blocks that nobody may take
  int lodepng = 0;                ///< blocks
  int simulator = 0;              ///< blocks
  std::size_t lodepng_live = 0;   ///< bytes that it has not freed
  std::size_t lodepng_peak = 0;   ///< bytes
  bool lodepng_overflow = false;  ///< more blocks than could be followed
};

/// Armed from construction to destruction. One at a time.
class HeapTrap {
 public:
  HeapTrap();
  ~HeapTrap() { disarm(); }
  HeapTrap(const HeapTrap&) = delete;
  HeapTrap& operator=(const HeapTrap&) = delete;
  /// May be called again.
  HeapUse disarm();
  /// Where the first blocks were taken, on standard error.
  static void print_stacks();
};

}  // namespace plumbline
