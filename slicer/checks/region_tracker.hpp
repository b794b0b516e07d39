#pragma once
/// The checks of regions: islands, what falls, resin traps and suction cups.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/checks/check_limits.hpp"
#include "slicer/checks/film.hpp"
#include "slicer/checks/island_rule.hpp"
#include "slicer/checks/region_columns.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/checks/tear_finder.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/regions/layer_regions.hpp"
#include "slicer/core/regions/region_contacts.hpp"

namespace plumbline::inline slicer {

/// The widest run of each region of a layer, and the regions but the outside in the order of their first runs.
/// @param widest  as many as the regions have runs; overwritten
/// @param visit   called with (region, whether it is white)
template <class Visit>
void for_each_region(const LayerRegions& regions, std::span<std::uint32_t> widest, Visit visit) {
  const auto length = [&](std::uint32_t i) { return regions.run(i).last - regions.run(i).first; };
  for (std::uint32_t i = 1; i < regions.run_count(); ++i) {
    const std::uint32_t region = regions.region(i);
    if (regions.run(i).first > regions.run(i).last || region == LayerRegions::kOutside) continue;
    if (region == i || length(i) > length(widest[region])) widest[region] = i;
  }
  for (std::uint32_t r = 0; r < regions.rows(); ++r) {
    for (std::uint32_t i = regions.row_begin(r); i < regions.row_begin(r + 1); ++i) {
      if (regions.region(i) == i && regions.run(i).first <= regions.run(i).last) visit(i, regions.white(r, i));
    }
  }
}

/// An issue that is a region of a layer.
/// @param run  its widest run, whose middle is its place
inline Issue issue_at(IssueKind kind, std::uint32_t layer, const LayerRegions& regions, std::uint32_t run) {
  const LayerRegions::Run& widest = regions.run(run);
  const std::uint32_t pixels = regions.area(regions.region(run));
  return {kind, layer, layer, layer, (widest.first + widest.last + 1U) / 2, regions.row_of(run), pixels, pixels};
}

/// Only two layers are in memory. Regions of a layer are labelled as runs; regions of consecutive layers that touch belong
/// to one column (union-find), which carries its size, its largest region and whether it is held or open. So nothing has to be
/// swept downwards: a hollow becomes a suction cup when it opens, and a resin trap when it ends without having opened.
///
/// From the first piece that falls on, a region is held only by its pixels that get light and touch what stayed below: see Film.
class RegionTracker {
 public:
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<RegionTracker> create(const PrintGrid& grid, const CheckLimits& limits, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid);

  /// Takes the layers one after the other. One that has more regions than there is room for is counted and left out: all of the
  /// layer above it is held, and its air is open.
  /// @param eroded   the layer's overhangs: see erode_fresh()
  /// @param scratch  of the same size; overwritten
  void next(ConstBitImage mask, ConstBitImage eroded, BitImage scratch, StackFindings& findings);
  /// Whether what is white at a pixel of the newest layer is held; also if its regions were not looked at.
  bool is_held(std::uint32_t column, std::uint32_t row) const {
    return !below_is_known_ || below().column[below().regions.region(below().regions.run_at(column, row))] == 0;
  }
  /// Calls visit(issue, regions, region) for each white region of the newest layer, if its regions were looked at.
  template <class Visit>
  void for_each_white(IssueKind kind, Visit visit) const {
    for (std::uint32_t i = 0; below_is_known_ && i < root_count_; ++i) {
      const std::uint32_t region = roots_[i] & ~kWhite;
      if (region == roots_[i]) continue;
      visit(issue_at(kind, layer_ - 1, below().regions, widest_[region]), below().regions, region);
    }
  }
  /// After the last one.
  void finish(StackFindings& findings);

 private:
  struct Layer {
    LayerRegions regions;
    std::span<std::uint32_t> column;  ///< by region: its number in solid_ or air_; kNone: not known yet
  };
  struct Contact {
    std::uint32_t above, below;  ///< a region, later its column; a column of the layer below
    std::uint32_t pixels;
  };
  static constexpr std::uint32_t kNone = RegionColumn::kNone;
  static constexpr std::uint32_t kWhite = std::uint32_t{1} << 31;  ///< marks white regions in roots_

  RegionTracker(const PrintGrid& grid, const CheckLimits& limits, const IslandRule& islands)
      : scale_(grid), limits_(limits), islands_(islands) {}

  bool track(ConstBitImage mask, ConstBitImage eroded, BitImage scratch, StackFindings& findings);
  bool find_contacts();
  bool start_columns();
  void find_islands(ConstBitImage eroded, BitImage scratch, StackFindings& findings);
  bool find_what_stays(ConstBitImage mask, BitImage lit, bool& any_falls, StackFindings& findings);
  void join_solid();
  bool find_tears(const LayerRegions& stayed, bool shaded);
  void join_air(StackFindings& findings);
  void count_regions();
  void end_layer(StackFindings& findings);
  void add_column(IssueKind kind, const RegionColumn& column, StackFindings& findings);
  bool add_cup(const RegionColumn& column, StackFindings& findings);

  Layer& now() { return layers_[now_]; }
  const Layer& now() const { return layers_[now_]; }
  const Layer& below() const { return layers_[below_]; }
  /// One that is neither a nor b.
  static std::uint32_t another(std::uint32_t a, std::uint32_t b) { return a != b ? 3 - a - b : (a + 1) % 3; }

  IssueScale scale_;
  CheckLimits limits_;
  IslandRule islands_;
  std::uint32_t layer_ = 0;
  bool below_is_known_ = false;  ///< its regions are
  // Regions of the masks, and of what got light and stayed. These are the masks' while the film is clean.
  std::array<Layer, 3> layers_;
  std::uint32_t now_ = 0, below_ = 0;  ///< of the masks
  std::uint32_t stayed_now_ = 0, stayed_below_ = 0;
  std::span<std::uint32_t> roots_;   ///< the regions of the layer, white ones marked
  std::span<std::uint32_t> shared_;  ///< by region: pixels above white ones; later those that stay
  std::span<std::uint32_t> widest_;  ///< by region: its widest run
  std::uint32_t root_count_ = 0;
  RegionContacts touches_;       ///< of the newest two layers
  std::span<Contact> contacts_;  ///< [0, solid_contacts_) of solid, [air_contacts_, end) of air
  std::size_t solid_contacts_ = 0, air_contacts_ = 0;
  RegionColumns solid_, air_;  ///< column 0: held; open to the outside
  Film film_;
  TearFinder tears_;
};

}  // namespace plumbline::inline slicer
