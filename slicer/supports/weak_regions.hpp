#pragma once
/// Finds regions of a layer that next to nothing below holds.

#include <bit>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/regions/island_share.hpp"
#include "slicer/core/regions/layer_regions.hpp"
#include "slicer/supports/tips.hpp"

namespace plumbline::inline slicer {

/// A region of a layer is weak if something holds it, but so little that it is an island whatever its overhangs are (IslandShare).
class WeakRegions {
 public:
  WeakRegions() = default;
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<WeakRegions> create(std::uint32_t columns, std::uint32_t rows, Arena& arena);
  static std::size_t bytes_needed(std::uint32_t rows);

  /// Where a tip holds it best: the middle of its widest run of new pixels.
  struct Place {
    std::uint32_t column = 0, row = 0;
    std::uint32_t pixels = 0;  ///< of the region
  };

  /// Looks at a layer. One with more runs than there is room for has none.
  /// @param below  the layer below, with heads of supports
  /// @param tips   of this layer: a region with one is not weak
  void look_at(ConstBitImage mask, ConstBitImage below, std::span<const Tip> tips);
  /// Calls visit(place) for each weak region.
  template <class Visit>
  void for_each(ConstBitImage mask, ConstBitImage below, Visit visit) const {
    if (!any_) return;
    regions_.for_each_white_run([&](std::uint32_t, std::uint32_t i) {
      if (regions_.region(i) == i && is_weak(i)) visit(place_in(i, mask, below));
    });
  }

 private:
  bool is_weak(std::uint32_t region) const;
  Place place_in(std::uint32_t region, ConstBitImage mask, ConstBitImage below) const;

  LayerRegions regions_;
  std::span<std::uint32_t> held_;  ///< by region: pixels that continue from below; kNone: it has a tip
  bool any_ = false;               ///< regions_ are those of the layer
};

}  // namespace plumbline::inline slicer
