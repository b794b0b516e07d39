#pragma once
/// Which regions of a layer are islands: README.md has the rule and how it differs from UVtools'.

#include <cstddef>
#include <cstdint>

#include "slicer/checks/check_limits.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/regions/layer_regions.hpp"
#include "slicer/supports/near.hpp"

namespace plumbline::inline slicer {

class IslandRule {
 public:
  /// A layer and the one below it.
  struct Layers {
    const LayerRegions& regions;
    const LayerRegions& below;
    ConstBitImage eroded;           ///< the layer's overhangs: see erode_fresh()
    BitImage scratch;               ///< of the mask's size; overwritten
    bool scratch_is_black = false;  ///< for the rule itself
  };

  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<IslandRule> create(const PrintGrid& grid, const CheckLimits& limits, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid);

  /// @param region  white
  /// @param shared  its pixels above white ones
  bool is_island(std::uint32_t region, std::uint32_t shared, Layers& layers) const;

 private:
  IslandRule(const PrintGrid& grid, const CheckLimits& limits) : scale_(grid), limits_(limits) {}

  bool overhangs(std::uint32_t region, std::uint32_t shared, const Layers& layers) const;
  bool rests_on_tips(std::uint32_t region, std::uint32_t shared, Layers& layers) const;

  IssueScale scale_;
  CheckLimits limits_;
  Disc reach_;  ///< kIslandTipsReach_mm
};

}  // namespace plumbline::inline slicer
