#pragma once
/// What a thread needs to meet its deadlines. Needs permission.

namespace plumbline::inline hal::inline linux_board {

/// Runs the calling thread before all threads of lower or no real-time priority (SCHED_FIFO).
/// @param priority  1 to 99
/// @returns false if not permitted; then the thread runs as before
bool set_real_time_priority(int priority);

/// Turning the lamp off comes before steps. Both stay below 50, where Linux runs threaded interrupts, or level with it.
inline constexpr int kKeeperPriority = 50;
inline constexpr int kStagePriority = 40;

}  // namespace plumbline::inline hal::inline linux_board
