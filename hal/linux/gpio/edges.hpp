#pragma once
/// What an input line has done since somebody last looked.

namespace plumbline {

/// Changes of a line that the kernel keeps until they are asked for; further ones are lost.
inline constexpr int kEdgesKept = 16;

/// Calls `see` with each change of a line that was not asked for yet, the oldest first: with one more than the kernel keeps at most, for
/// a line that hums changes as fast as it is read.
/// @param line  has next_edge(), which gives nothing when there is no change left
/// @returns false: there may be more; they are left for the next look
template <typename Line, typename See>
bool see_edges(Line& line, See see) {
  for (int seen = 0; seen <= kEdgesKept; ++seen) {
    const auto edge = line.next_edge();
    if (!edge) return true;
    see(*edge);
  }
  return false;
}

}  // namespace plumbline
