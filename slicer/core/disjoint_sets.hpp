#pragma once
/// Disjoint sets of indices (union-find).

#include <cstdint>
#include <functional>
#include <span>
#include <utility>

namespace plumbline::inline slicer {

/// Disjoint sets of the indices of `entries`, each of which keeps its parent's index. The root of a set is its lowest
/// index, whatever the order of the unions. The entries are the caller's; this class is only a view of them.
///
/// root() halves the paths it walks (Tarjan and van Leeuwen 1984): O(log n) amortised, without a rank to store.
///
/// @tparam Parent  gives the parent (std::uint32_t&) of an entry: the entry itself, or a pointer to its member
template <class Entry = std::uint32_t, auto Parent = std::identity{}>
class DisjointSets {
 public:
  DisjointSets() = default;
  explicit DisjointSets(std::span<Entry> entries) : entries_(entries) {}

  std::uint32_t size() const { return static_cast<std::uint32_t>(entries_.size()); }

  /// Makes i a set of its own. Call it before any other use of i.
  void start(std::uint32_t i) { parent(i) = i; }
  void start_all() {
    for (std::uint32_t i = 0; i < size(); ++i) start(i);
  }

  bool is_root(std::uint32_t i) const { return parent(i) == i; }

  /// Lowest index of the set that holds i. For one thread, as it shortens the path.
  std::uint32_t root(std::uint32_t i) const {
    while (parent(i) != parent(parent(i))) i = parent(i) = parent(parent(i));
    return parent(i);
  }

  struct Union {
    std::uint32_t root = 0;      ///< of the joined set
    std::uint32_t absorbed = 0;  ///< the other set's former root; equal to `root` if a and b were in one set already
  };
  /// Joins the sets of a and b.
  Union unite(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (b < a) std::swap(a, b);
    parent(b) = a;
    return {a, b};
  }

  /// Sets the parent of each of the first `count` indices to its root.
  void flatten(std::uint32_t count) {
    // A parent is a lower index, so it already points to its root.
    for (std::uint32_t i = 0; i < count; ++i) parent(i) = parent(parent(i));
  }

 private:
  std::uint32_t& parent(std::uint32_t i) const { return std::invoke(Parent, entries_[i]); }

  std::span<Entry> entries_;
};

}  // namespace plumbline::inline slicer
