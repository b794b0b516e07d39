#pragma once
/// Reads the changes of an input line.

namespace plumbline::inline hal::inline linux_board {

/// The kernel buffers this many changes of a line and drops further ones.
inline constexpr int kKernelEdges = 16;

/// Calls `see` with each unread change of a line, oldest first. Stops after one more than the kernel buffers, because a line that hums
/// changes as fast as it is read.
/// @param line  has next_edge(), which returns nothing when no change is left
/// @returns false if there may be more, left for the next call
template <typename Line, typename See>
bool for_each_edge(Line& line, See see) {
  for (int seen = 0; seen <= kKernelEdges; ++seen) {
    const auto edge = line.next_edge();
    if (!edge) return true;
    see(*edge);
  }
  return false;
}

}  // namespace plumbline::inline hal::inline linux_board
