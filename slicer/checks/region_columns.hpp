#pragma once
/// Regions of consecutive layers that belong together, tracked while the layers pass.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/disjoint_sets.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline slicer {

/// A set of regions of consecutive layers, and what is known of it so far.
struct RegionColumn {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::uint32_t parent = 0;
  std::uint32_t first_layer = kNone, last_layer = 0;
  std::uint64_t voxels = 0;                           ///< 0: no region of it has been counted yet
  std::uint32_t largest = 0;                          ///< pixels of its largest region,
  std::uint32_t largest_layer = 0;                    ///< which is here
  std::uint32_t column = 0, row = 0;                  ///< in the middle of that region's widest run
  std::uint32_t broad_first = kNone, broad_last = 0;  ///< layers with a broad region
  bool on_plate = false;                              ///< has a region in layer 0
  bool drains = false;                                ///< has a region large enough to drain
  bool alive = false;                                 ///< has a region in the newest layer
  bool torn = false;                                  ///< tore off: `largest` and its place are those of the tear
  float asked_n = 0, held_n = 0;                      ///< of a tear

  void add(const RegionColumn& other);
};

/// Union-find over the columns that reach into the newest layer. Column 0 is the one that matters to no finding: air that
/// reaches the outside, or solid that is held. The memory is for one layer's regions and the columns below them.
class RegionColumns {
 public:
  /// @param most  columns, and regions of one layer
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<RegionColumns> create(std::uint32_t most, Arena& arena);
  static std::size_t bytes_needed(std::uint32_t most) {
    return 2 * Arena::rounded(std::size_t{2} * most * sizeof(RegionColumn));
  }

  /// Makes a column for a region of the newest layer.
  /// @returns its number; kNone: there is no room
  std::uint32_t start(bool drains, bool on_plate) {
    if (count_ == nodes_.size()) return RegionColumn::kNone;
    nodes_[count_] = RegionColumn{};
    nodes_[count_].parent = count_;
    nodes_[count_].drains = drains;
    nodes_[count_].on_plate = on_plate;
    return count_++;
  }
  std::uint32_t root(std::uint32_t node) const { return Sets(nodes_).root(node); }
  RegionColumn& column(std::uint32_t node) const { return nodes_[root(node)]; }
  bool is_first(std::uint32_t node) const { return root(node) == 0; }

  void unite(std::uint32_t a, std::uint32_t b) {
    const auto [kept, absorbed] = Sets(nodes_).unite(a, b);
    if (kept != absorbed) nodes_[kept].add(nodes_[absorbed]);
  }

  /// Ends the layer. Columns without a region in it end.
  /// @param on_end  called with each column that ends, lowest number first
  template <class OnEnd>
  void end_layer(OnEnd on_end) {
    std::uint32_t kept = 1;
    for (std::uint32_t i = 1; i < count_; ++i) {
      if (nodes_[i].parent != i) continue;
      if (!nodes_[i].alive) {
        on_end(nodes_[i]);
        continue;
      }
      next_[kept] = nodes_[i];
      next_[kept].parent = kept;
      next_[kept].alive = false;
      number(i) = kept++;
    }
    number(0) = 0;
    kept_ = kept;
  }
  /// Between end_layer() and begin_layer(): the number that a node's column has from now on.
  std::uint32_t next_number(std::uint32_t node) const { return nodes_[root(node)].largest_layer; }
  /// Takes the columns that were kept as those of the layer below.
  void begin_layer();
  /// Number of columns of the layer below, 0 included, and each as it was before anything was united with it. Until end_layer().
  std::uint32_t below_count() const { return kept_; }
  const RegionColumn& below(std::uint32_t number) const { return next_[number]; }
  /// Forgets all columns but 0.
  void clear();

 private:
  using Sets = DisjointSets<RegionColumn, &RegionColumn::parent>;

  /// The copied column's number overwrites a field that is no longer needed.
  std::uint32_t& number(std::uint32_t root) { return nodes_[root].largest_layer; }

  std::span<RegionColumn> nodes_, next_;
  std::uint32_t count_ = 1;  ///< of nodes_
  std::uint32_t kept_ = 1;   ///< of next_
};

}  // namespace plumbline::inline slicer
