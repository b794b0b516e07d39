#pragma once
/// What a thread or process needs to keep its deadlines. Neither is allowed everywhere.

namespace plumbline {

/// The calling thread runs before all others that are not real-time (SCHED_FIFO).
/// @param priority  1 to 99
/// @returns false: not permitted. It runs as before
bool run_first(int priority);

/// Priorities of ours: the keeper goes before the stage.
inline constexpr int kKeeperPriority = 50;
inline constexpr int kStagePriority = 40;

/// No page of the process, once touched, is ever written out or fetched again. (The arena is larger than what a job touches.)
/// @returns false: not permitted, or more than RLIMIT_MEMLOCK
bool lock_memory();

/// The C library's heap asks the kernel for nothing more: room for what a stick that comes needs of it is taken now, all threads share
/// it, and none of it is given back. To be called before the first other thread.
void hold_heap();

}  // namespace plumbline
