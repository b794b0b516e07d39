#pragma once
/// Finds the supports of a print, from its masks alone (thesis I).

#include <cstddef>
#include <cstdint>
#include <optional>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/dose/adaptive_layers.hpp"
#include "slicer/dose/bleed.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/supports/tips.hpp"

namespace plumbline::inline slicer {

/// Number of supports, one for each tip, by their purpose, by where their load goes and by its size; and what else was found.
struct SupportCounts {
  std::uint32_t islands = 0;    ///< tips below islands
  std::uint32_t overhangs = 0;  ///< tips below overhangs
  std::uint32_t on_plate = 0;
  std::uint32_t on_object = 0;
  std::uint32_t on_supports = 0;  ///< hang on another support's pillar
  std::uint32_t light = 0, medium = 0, heavy = 0;
  UnreachedTips unreached_islands, unreached_overhangs;
  std::uint32_t added = 0;           ///< of settings.added, reached or not; they count as tips, too
  std::uint32_t missed = 0;          ///< bit i: none, since there is no surface at settings.added.list[i]
  LayerSteps steps;                  ///< of an adaptive print, chosen once it is known how the object stands
  std::optional<BleedCounts> bleed;  ///< corrected before supports were sought, or without any
  std::uint32_t braces = 0;
  std::uint32_t helpers = 0;  ///< pillars that carry nothing but brace another
  std::uint32_t specks = 0;   ///< left out of the print instead
  double specks_mm3 = 0;      ///< their volume
  /// Of the object's masks, by what was left out and cut off. Unknown if closing may have filled pixels beside a speck, which go with it.
  std::optional<std::uint64_t> lost_pixels;
  std::uint32_t pads = 0;       ///< below small regions of the first layer
  std::uint32_t unbraced = 0;   ///< pillars with more than 10 mm between braces
  std::uint32_t lifted = 0;     ///< layers by which the object was lifted
  std::uint32_t sunk = 0;       ///< layers that were cut off below it
  std::optional<bool> flat;     ///< whether the underside is flat; none: the object was raised anyway
  double longest_free_mm = 0;   ///< longest stretch of a pillar without a brace
  double largest_load_mm2 = 0;  ///< of overhang, on one tip

  std::uint32_t all() const { return on_plate + on_object + on_supports; }
  std::uint32_t unreached() const { return unreached_islands.count + unreached_overhangs.count; }
};

/// Chooses how the object stands (stand.hpp), finds what must be held and what is too small to be (tips.hpp), leads it to the plate (routing.hpp), braces
/// the pillars (bracing.hpp), puts a raft below a lifted object (raft.hpp) and pads below small feet on the plate (feet.hpp).
/// @param rrep         the newest block at the bottom of the arena; changed if the object sinks, is lifted, or
///                     loses specks
/// @param settings     accepted by check_support_settings()
/// @param most_layers  that the printer can print
/// @param arena        keeps the list at the bottom; find_supports_bytes() are needed while this runs
/// @param progress     may be null
/// @param counts       overwritten
/// @param cure         if it is known, the object is corrected for bleed first, once it is known how it stands
/// @param adaptive     if it is wanted, the heights of the print's layers are chosen before that
/// @retval ErrorCode::kDoesNotFit   the lifted object is too high
/// @retval ErrorCode::kOutOfMemory  the arena is full, or more than most_tips() are needed
/// @retval ErrorCode::kCancelled    `progress` asked to stop
[[nodiscard]] Expected<Supports> find_supports(RRep& rrep, const SupportSettings& settings, std::uint32_t most_layers,
                                               Arena& arena, ProgressSink* progress, SupportCounts& counts,
                                               const CureModel& cure = {}, const AdaptiveLayers& adaptive = {});

/// Peak bytes of arena of find_supports(), its list included, for any object and settings.
std::size_t find_supports_bytes(const PrintGrid& grid);
/// The same for this object. Without a tip it takes less.
std::size_t find_supports_bytes(const RRep& rrep, const SupportSettings& settings);

/// Largest number of struts.
std::uint32_t most_struts(const PrintGrid& grid);

}  // namespace plumbline::inline slicer
