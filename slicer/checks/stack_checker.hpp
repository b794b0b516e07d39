#pragma once
/// Finds what would go wrong with a stack of masks, in one sweep from the plate up.

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/checks/check_limits.hpp"
#include "slicer/checks/layer_measures.hpp"
#include "slicer/checks/overhangs.hpp"
#include "slicer/checks/region_tracker.hpp"
#include "slicer/checks/slender_parts.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/regions/layer_regions.hpp"
#include "slicer/supports/held_area.hpp"

namespace plumbline::inline slicer {

/// Takes the masks of a stack one after the other, and holds no more than two of them. README.md says what each check looks
/// for.
class StackChecker {
 public:
  /// @param grid  of the masks; grid.layers is not used
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<StackChecker> create(const PrintGrid& grid, const CheckLimits& limits, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid, OverhangRule overhangs = OverhangRule::kEroded);

  /// @param mask  the next layer's, of the grid's size
  void next(ConstBitImage mask);
  /// The same in two steps: take() copies the mask, then check_while() calls `meanwhile` in one of the job's threads while another
  /// one checks. It may draw the next mask.
  void take(ConstBitImage mask);
  void check_while(FunctionRef<void()> meanwhile);

  /// After the last layer. Call it once.
  const StackFindings& finish();

 private:
  void check();
  bool find_needing_support(const RegionBox& box);
  void tell_needing_support();
  StackChecker(const PrintGrid& grid, const CheckLimits& limits, const RegionTracker& regions,
               const SlenderParts& slender)
      : limits_(limits), measures_(grid, limits), regions_(regions), slender_(slender) {}

  SeenLayer compare_with_below(ConstBitImage mask);
  bool find_overhangs(const RegionBox& box);
  void find_slender_parts();
  bool has_contour_area(std::uint32_t region) const;

  CheckLimits limits_;
  StackFindings findings_;
  LayerMeasures measures_;
  RegionTracker regions_;
  SlenderParts slender_;
  std::uint32_t layer_ = 0;
  SeenLayer below_;
  SeenLayer taken_;                  ///< not checked yet
  BitImage below_mask_;              ///< from take() on the layer itself
  BitImage fresh_, eroded_;          ///< black between layers
  LayerRegions overhangs_;           ///< of the layer's eroded new pixels
  std::span<std::uint32_t> widest_;  ///< by region of overhangs_: its widest run
  HeldArea held_;                    ///< for OverhangRule::kNeedSupport
  BitImage marks_;                   ///< words of fresh_ with new pixels, one bit each
};

}  // namespace plumbline::inline slicer
