#pragma once
/// Which regions of two consecutive layers touch.

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/regions/layer_regions.hpp"

namespace plumbline::inline slicer {

/// The contacts of two layers' regions, by pairs: a pillar's rows make one contact. The outside's contact with itself is left out. A pair
/// may be listed more than once if its rows lie between those of other pairs of the same region below.
class RegionContacts {
 public:
  /// @param most_runs  of a layer
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<RegionContacts> create(std::size_t most_runs, Arena& arena);
  static std::size_t bytes_needed(std::size_t most_runs);

  /// Contacts that there is room for.
  static std::size_t room(std::size_t most_runs);

  /// @returns false if there are more than room()
  bool find(const LayerRegions& below, const LayerRegions& above);

  /// In the order in which the pairs begin, by rows and from left to right.
  std::span<const RegionContact> list() const { return list_.first(count_); }

 private:
  std::span<RegionContact> list_;
  std::span<std::uint32_t> newest_;  ///< by region below: index of its newest contact
  std::size_t count_ = 0;
};

}  // namespace plumbline::inline slicer
