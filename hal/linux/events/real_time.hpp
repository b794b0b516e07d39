#pragma once
/// What a thread or process needs to meet its deadlines. Needs permission.

namespace plumbline {

/// Runs the calling thread before all threads of lower or no real-time priority (SCHED_FIFO).
/// @param priority  1 to 99
/// @returns false if not permitted; then the thread runs as before
bool set_real_time_priority(int priority);

/// Turning the lamp off comes before steps. Both stay below 50, where Linux runs threaded interrupts, or level with it.
inline constexpr int kKeeperPriority = 50;
inline constexpr int kStagePriority = 40;

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

}  // namespace plumbline
