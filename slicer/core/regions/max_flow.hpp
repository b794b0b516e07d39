#pragma once
/// The largest flow from loads to the plate.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace plumbline::inline slicer {

/// What an undirected graph can carry from loads to vertex 0, the plate (Ford and Fulkerson 1962), by E. A. Dinic's algorithm (1970).
///
/// @tparam Graph  derives from this, and has: vertices(), their number; first_arc(vertex); arc(index), with its members to, flow, and next, which
///                is an arc of the same vertex; room(index), what the arc can still carry. Arcs 2 e and 2 e + 1 are the halves of edge e: the flow of
///                one is the other's negative.
template <class Graph>
class MaxFlow {
 protected:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::uint32_t kPlate = 0;
  static constexpr double kNothing = 1e-9;  ///< newtons below which a rest is rounding
  static constexpr std::size_t kListsOfVertices = 4;

  /// @param lists  kListsOfVertices lists
  void work_in(const std::span<std::uint32_t> (&lists)[kListsOfVertices]) {
    level_ = lists[0];
    current_ = lists[1];
    queue_ = lists[2];
    path_ = lists[3];
  }

  /// Sends as much to the plate as the edges carry, beside the flow there is.
  /// @param rest  of each load, in and out: what has not arrived
  /// @param at    called with the index of a load that has a rest: its vertex
  /// @returns whether all arrived
  template <class At>
  bool carry(std::span<double> rest, At at) {
    while (find_levels(rest, at)) {
      for (std::uint32_t vertex = 0; vertex < graph().vertices(); ++vertex)
        current_[vertex] = graph().first_arc(vertex);
      for (std::uint32_t i = 0; i < rest.size(); ++i) {
        while (rest[i] > kNothing) {
          const double carried = augment(at(i), rest[i]);
          if (carried <= 0) break;
          rest[i] -= carried;
        }
      }
    }
    return std::ranges::none_of(rest, [](double newtons) { return newtons > kNothing; });
  }
  /// The vertices that one could still send to; reached() tells which. After carry() from a load with a rest, these are what is cut off.
  std::span<const std::uint32_t> reach_from(std::uint32_t vertex) {
    return search(vertex, [&](std::uint32_t arc) { return graph().room(arc) > kNothing; });
  }
  bool reached(std::uint32_t vertex) const { return level_[vertex] != kNone; }

 private:
  Graph& graph() { return static_cast<Graph&>(*this); }

  /// Breadth first over the arcs for which open(arc) is true.
  template <class Open>
  std::span<const std::uint32_t> search(std::uint32_t from, Open open) {
    std::fill_n(level_.begin(), graph().vertices(), kNone);
    std::uint32_t count = 0;
    queue_[count++] = from;
    level_[from] = 0;
    for (std::uint32_t at = 0; at < count; ++at) {
      const std::uint32_t here = queue_[at];
      for (std::uint32_t arc = graph().first_arc(here); arc != kNone; arc = graph().arc(arc).next) {
        const std::uint32_t there = graph().arc(arc).to;
        if (reached(there) || !open(arc)) continue;
        level_[there] = level_[here] + 1;
        queue_[count++] = there;
      }
    }
    return queue_.first(count);
  }
  /// Arcs to the plate, against the flow.
  /// @returns whether a load with a rest has a way there
  template <class At>
  bool find_levels(std::span<const double> rest, At at) {
    search(kPlate, [&](std::uint32_t arc) { return graph().room(arc ^ 1U) > kNothing; });
    for (std::uint32_t i = 0; i < rest.size(); ++i) {
      if (rest[i] > kNothing && reached(at(i))) return true;
    }
    return false;
  }
  /// Sends up to `most` along one path of falling levels to the plate.
  /// @returns what it sent
  double augment(std::uint32_t from, double most) {
    std::uint32_t length = 0;
    std::uint32_t here = from;
    while (here != kPlate) {
      std::uint32_t& arc = current_[here];
      const auto falls = [&] {
        const std::uint32_t level = level_[graph().arc(arc).to];
        return reached(here) && level != kNone && level + 1 == level_[here] && graph().room(arc) > kNothing;
      };
      while (arc != kNone && !falls()) arc = graph().arc(arc).next;
      if (arc != kNone) {
        path_[length++] = arc;
        here = graph().arc(arc).to;
        continue;
      }
      if (length == 0) return 0;
      here = graph().arc(path_[--length] ^ 1U).to;  // a dead end
      current_[here] = graph().arc(current_[here]).next;
    }
    double carried = most;
    for (const std::uint32_t arc : path_.first(length)) carried = std::min(carried, graph().room(arc));
    for (const std::uint32_t arc : path_.first(length)) {
      graph().arc(arc).flow += carried;
      graph().arc(arc ^ 1U).flow -= carried;
    }
    return carried;
  }

  std::span<std::uint32_t> level_;    ///< of a vertex: arcs from where the search began
  std::span<std::uint32_t> current_;  ///< of a vertex: the next arc to try
  std::span<std::uint32_t> queue_;    ///< vertices
  std::span<std::uint32_t> path_;     ///< arcs
};

}  // namespace plumbline::inline slicer
