#pragma once
/// Finds islands: regions of a layer that nothing below holds.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/disjoint_sets.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/regions/island_share.hpp"
#include "slicer/supports/window.hpp"

namespace plumbline::inline slicer {

/// Finds the regions of a layer that have no pixel above the layer below. Pixels are joined at sides, not at corners, where a
/// print would tear.
///
/// All pixels of an island are new. So only new pixels are looked at, as runs, row by row (the two-row labelling of Rosenfeld
/// and Pfaltz 1966, with labels reused after each row). It takes memory for two rows, and time for what changes.
class IslandFinder {
 public:
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<IslandFinder> create(std::uint32_t columns, Arena& arena);
  static std::size_t bytes_needed(std::uint32_t columns);

  /// The middle pixel of the widest run of an island.
  struct Place {
    std::uint32_t column = 0, row = 0;
    std::uint32_t pixels = 0;  ///< of the island
  };

  /// Takes the next row of a layer, the first one after create() or end().
  /// @param mask    of the layer
  /// @param below   of the layer below, with heads of supports
  /// @param fresh   new pixels: mask and not below
  /// @param window  where `fresh` may have pixels
  /// @param visit   called with a Place for each island that ended above this row
  template <class Visit>
  void next_row(ConstBitImage mask, ConstBitImage below, ConstBitImage fresh, std::uint32_t row, const Window& window,
                Visit visit) {
    read_runs(mask, below, fresh, row, window);
    join_with_row_above();
    for (std::uint32_t i = 0; i < open_; ++i) {
      if (regions_[i].parent == i && !regions_[i].goes_on) close(regions_[i], visit);
    }
    keep_what_goes_on();
  }
  /// After the last row: visits the islands that reach into it.
  template <class Visit>
  void end(Visit visit) {
    for (std::uint32_t i = 0; i < open_; ++i) close(regions_[i], visit);
    open_ = 0;
  }
  /// Whether an island may go on into the next row.
  bool any_open() const { return open_ > 0; }
  /// Whether the layer may have weak regions (WeakRegions): more new pixels in one piece than sides at which it is held, by so much as
  /// such a region has. Until the next row.
  bool may_be_weak() const { return may_be_weak_; }

 private:
  struct Run {
    std::uint32_t begin = 0, end = 0;  ///< columns
    std::uint32_t region = 0;
  };
  struct Region {
    std::uint32_t parent = 0;
    std::uint32_t width = 0;  ///< pixels of its widest run
    Place middle;             ///< of that run
    std::uint32_t sides = 0;  ///< at which its pixels are beside one that continues from below
    bool goes_on = false;     ///< into the row being read
  };

  static constexpr std::uint32_t kFewSides = 4 * IslandShare{}.held_pixels;  ///< that many pixels have no more
  static constexpr std::uint32_t kManyPixels =
      IslandShare{}.held_divisor;  ///< for each side: a sixteenth of them is a quarter of a pixel

  using Sets = DisjointSets<Region, &Region::parent>;

  template <class Visit>
  void close(const Region& region, Visit visit) {
    if (region.sides == 0) {
      visit(region.middle);
    } else if (region.middle.pixels > region.sides) {
      may_be_weak_ = may_be_weak_ || region.sides < kFewSides || region.middle.pixels / kManyPixels > region.sides;
    }
  }
  void read_runs(ConstBitImage mask, ConstBitImage below, ConstBitImage fresh, std::uint32_t row, const Window& window);
  void join_with_row_above();
  void keep_what_goes_on();

  std::span<Run> above_, here_;
  std::uint32_t above_count_ = 0, here_count_ = 0;
  std::span<Region> regions_, kept_;  ///< [0, open_): those with a run in the row above; then one for each run here
  std::uint32_t open_ = 0;
  bool may_be_weak_ = false;
};

}  // namespace plumbline::inline slicer
