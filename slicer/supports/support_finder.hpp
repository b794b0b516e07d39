#pragma once
/// Finds where supports are needed, from the sequence of masks alone (DESIGN 3, stage 10; thesis I).

#include <cstddef>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/supports/supports.hpp"

namespace plumbline {

/// What the supports are for, and where they end.
struct SupportCounts {
  std::uint32_t islands = 0;    ///< tips below a piece that begins in the air
  std::uint32_t overhangs = 0;  ///< tips below what juts out too far
  std::uint32_t on_plate = 0;
  std::uint32_t on_object = 0;
  std::uint32_t on_supports = 0;  ///< that branch off another one

  std::uint32_t all() const { return on_plate + on_object + on_supports; }
};

/// Sweeps the layers once, from the plate up, and puts supports
///   - below every island: a piece of a mask that has no pixel above the layer below or a head of a support;
///   - below what juts out: new pixels of a layer farther than max_bridge_length / 2 from what is *held*.
/// Held is layer 0, a tip's disc, what is within layer_height / tan(critical_angle) of held pixels a layer below, and what
/// has been there for so many layers that it would have been held by that growth. So a slope that is steeper than the
/// critical angle needs none, one that is less steep gets them at the distance at which it has fallen behind, and a
/// bridge is free up to max_bridge_length.
///
/// A support goes straight down from its tip, and ends where it meets another one, on the object, or on the plate.
/// @param settings  that check_support_settings() takes
/// @param arena     the list at the bottom, to stay; find_supports_bytes() while this runs, given back
/// @param progress  may be null
/// @param counts    overwritten
/// @retval ErrorCode::kOutOfMemory  the arena is full, or more supports are needed than fit into the list
/// @retval ErrorCode::kCancelled    progress said so
[[nodiscard]] Expected<Supports> find_supports(const RRep& rrep, const SupportSettings& settings, Arena& arena,
                                               ProgressSink* progress, SupportCounts& counts);

/// Most bytes of the arena that find_supports() uses at a time, its list included, for any object and settings.
std::size_t find_supports_bytes(const PrintGrid& grid);

/// Supports that the list has room for.
std::uint32_t most_supports(const PrintGrid& grid);

}  // namespace plumbline
