#pragma once
/// Finds where supports are needed, from the masks alone (thesis I).

#include <cstddef>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/supports/supports.hpp"

namespace plumbline {

/// Number of supports, by their purpose and by where they end.
struct SupportCounts {
  std::uint32_t islands = 0;    ///< tips below islands
  std::uint32_t overhangs = 0;  ///< tips below overhangs
  std::uint32_t on_plate = 0;
  std::uint32_t on_object = 0;
  std::uint32_t on_supports = 0;  ///< branches of another support

  std::uint32_t all() const { return on_plate + on_object + on_supports; }
};

/// Sweeps the object's masks once, from the plate up, and puts supports
///   - below every island: a region of a mask that has no pixel above the layer below or above the head of a support;
///   - below overhangs: new pixels of a layer farther than max_bridge_length / 2 from all *held* pixels.
/// Held are layer 0, the discs of tips, pixels within layer_height / tan(critical_angle) of held pixels a layer below, and
/// pixels that have been there for as many layers as that growth would have needed (HeldArea). So a slope steeper than the
/// critical angle needs no support, a flatter one gets them where it has fallen behind, and bridges up to max_bridge_length
/// are free.
///
/// A support goes straight down from its tip and ends on another support, on the object or on the plate.
/// @param settings  accepted by check_support_settings()
/// @param arena     keeps the list at the bottom; find_supports_bytes() are needed while this runs
/// @param progress  may be null
/// @param counts    overwritten
/// @retval ErrorCode::kOutOfMemory  the arena is full, or more than most_supports() are needed
/// @retval ErrorCode::kCancelled    `progress` asked to stop
[[nodiscard]] Expected<Supports> find_supports(const RRep& rrep, const SupportSettings& settings, Arena& arena,
                                               ProgressSink* progress, SupportCounts& counts);

/// Peak bytes of arena of find_supports(), its list included, for any object and settings.
std::size_t find_supports_bytes(const PrintGrid& grid);

/// Largest number of supports.
std::uint32_t most_supports(const PrintGrid& grid);

}  // namespace plumbline
