#pragma once
/// Disjoint sets of things that have two sides.

#include <cstdint>
#include <span>
#include <utility>

namespace plumbline::inline slicer {

/// Disjoint sets whose members know their side relative to their root. For one thread.
///
/// Not built on DisjointSets, whose root is the lowest index: here the larger of two joined sets keeps its root, which a
/// sheet's side is relative to. Side, mark and size share the parent's word, four bytes a member:
///   root     kRoot, kFixed, number of members (or what set_value() put there)
///   others   kTurned (relative to the parent), kFixed, parent
class SidedSets {
 public:
  SidedSets() = default;
  /// @param entries  one a member, at most kIndex members; start() each of them first
  explicit SidedSets(std::span<std::uint32_t> entries) : entries_(entries) {}
  /// Makes i a set of its own.
  /// @param fixed  a mark of the member, for the caller
  void start(std::uint32_t i, bool fixed) { entries_[i] = kRoot | (fixed ? kFixed : 0U) | 1U; }

  struct Place {
    std::uint32_t root = 0;
    bool turned = false;  ///< relative to the root
  };
  /// Finds the root of i and shortens the path to it.
  Place find(std::uint32_t i) {
    const Place place = look(i);
    // All members on the path point to the root from now on.
    bool turned = place.turned;
    while ((entries_[i] & kRoot) == 0 && (entries_[i] & kIndex) != place.root) {
      const std::uint32_t entry = entries_[i];
      entries_[i] = (entry & kFixed) | (turned ? kTurned : 0U) | place.root;
      turned = turned != ((entry & kTurned) != 0);
      i = entry & kIndex;
    }
    return place;
  }
  /// Finds the root without shortening the path, so that many threads may call it.
  Place look(std::uint32_t i) const {
    bool turned = false;
    while ((entries_[i] & kRoot) == 0) {
      turned = turned != ((entries_[i] & kTurned) != 0);
      i = entries_[i] & kIndex;
    }
    return {i, turned};
  }
  /// Joins two different sets, given what find() returned for a member of each.
  /// @param turned  whether the two members face opposite sides
  void unite(Place a, Place b, bool turned) {
    if (value(a.root) < value(b.root)) std::swap(a, b);
    entries_[a.root] += value(b.root);
    const bool against = (a.turned != b.turned) != turned;
    entries_[b.root] = (entries_[b.root] & kFixed) | (against ? kTurned : 0U) | a.root;
  }
  bool is_root(std::uint32_t i) const { return (entries_[i] & kRoot) != 0; }
  bool fixed(std::uint32_t i) const { return (entries_[i] & kFixed) != 0; }
  /// Number of members of a root's set, or what set_value() put there.
  std::uint32_t value(std::uint32_t root) const { return entries_[root] & kIndex; }
  void set_value(std::uint32_t root, std::uint32_t v) { entries_[root] = (entries_[root] & ~kIndex) | v; }

  static constexpr std::uint32_t kIndex = (1U << 29) - 1;

 private:
  static constexpr std::uint32_t kRoot = 1U << 31;
  static constexpr std::uint32_t kTurned = 1U << 30;
  static constexpr std::uint32_t kFixed = 1U << 29;
  std::span<std::uint32_t> entries_;
};

}  // namespace plumbline::inline slicer
