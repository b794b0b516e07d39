#pragma once
/// Disjoint sets of indices (union-find).

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>

namespace plumbline {

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

  bool is_root(std::uint32_t i) const { return load(i) == i; }

  /// Lowest index of the set that holds i. Any thread may call it, also while others call unite_shared().
  std::uint32_t root(std::uint32_t i) const {
    for (;;) {
      const std::uint32_t up = load(i);
      const std::uint32_t above = load(up);
      if (above == up) return up;
      // `above` stays an ancestor of i, whatever other threads do meanwhile.
      std::atomic_ref(parent(i)).store(above, std::memory_order_relaxed);
      i = above;
    }
  }

  struct Union {
    std::uint32_t root = 0;      ///< of the joined set
    std::uint32_t absorbed = 0;  ///< the other set's former root; equal to `root` if a and b were in one set already
  };
  /// Joins the sets of a and b. For one thread.
  Union unite(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (b < a) std::swap(a, b);
    parent(b) = a;
    return {a, b};
  }
  /// Joins the sets of a and b; other threads may do the same meanwhile. The result does not depend on their order.
  void unite_shared(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = root(a);
      b = root(b);
      if (a == b) return;
      if (b < a) std::swap(a, b);
      std::uint32_t expected = b;  // still a root
      if (std::atomic_ref(parent(b)).compare_exchange_strong(expected, a, std::memory_order_relaxed)) return;
    }
  }

  /// Sets the parent of each of the first `count` indices to its root.
  void flatten(std::uint32_t count) {
    // A parent is a lower index, so it already points to its root.
    for (std::uint32_t i = 0; i < count; ++i) parent(i) = parent(parent(i));
  }

 private:
  std::uint32_t& parent(std::uint32_t i) const { return std::invoke(Parent, entries_[i]); }
  std::uint32_t load(std::uint32_t i) const { return std::atomic_ref(parent(i)).load(std::memory_order_relaxed); }

  std::span<Entry> entries_;
};

}  // namespace plumbline
