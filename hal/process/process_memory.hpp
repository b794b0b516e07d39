#pragma once
/// Keeps the memory of a process: what it has stays in RAM, and it asks the kernel for no more.

namespace plumbline::inline hal {

/// What lock_memory() does about pages that were never touched.
enum class Untouched : bool {
  kLeave,  ///< they are locked once they are touched: for a process with an arena larger than a job needs
  kLoad,   ///< they are loaded now: for a small process that must not wait for its program's file when it matters
};

/// Keeps every page of this process in memory, also of what it maps later.
/// @returns false if not permitted, or above RLIMIT_MEMLOCK
bool lock_memory(Untouched untouched);

/// Reserves heap for later allocations (a stick's arrival needs some), so that the process never asks the kernel for more. All
/// threads share one heap, and none of it is returned. Call it before starting threads.
void reserve_heap();

}  // namespace plumbline::inline hal
