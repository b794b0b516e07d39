#pragma once
/// How an object stands: on the plate, or raised above it on supports.

#include <cstdint>
#include <optional>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::inline slicer {

struct Stand {
  std::uint32_t sunk = 0;         ///< layers cut off below
  std::uint32_t lifted = 0;       ///< empty layers put below
  std::uint64_t sunk_pixels = 0;  ///< of the masks cut off
  std::optional<bool> flat = {};  ///< whether the underside is; none: the object is raised anyway
};

/// An underside is flat if a section at most kMostSunk_mm and 1 / kSunkShare of the height above the lowest point has at
/// least 1 / kFlatShare of the largest section's area, and at least half of the area of the section kFlatRise_mm higher. So a ball
/// is not flat, whatever its size: it has 9.8 % there. Nor is what lies on one end of its underside, while the rest of it begins
/// a little higher: supports there have no height to widen in, and tear off the plate. An object with a flat underside sinks to the
/// first such layer and stands on the plate. Any other is raised by object_elevation and the raft: its lowest layers would hold on
/// the plate with a tip's area, and be torn off. SupportSettings::stand overrules that.
inline constexpr double kMostSunk_mm = 0.3;
inline constexpr double kSunkShare = 40;
inline constexpr std::uint64_t kFlatShare = 10;
inline constexpr double kFlatRise_mm = 1;

/// @param most_layers  that the printer can print
/// @retval ErrorCode::kDoesNotFit   the raised object is too high
/// @retval ErrorCode::kOutOfMemory  no room for two images
[[nodiscard]] Expected<Stand> choose_stand(const RRep& rrep, const SupportSettings& settings, std::uint32_t most_layers,
                                           Arena& arena);

/// Cuts off and puts below. rrep must be the newest block at the bottom of the arena unless stand.sunk is 0.
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Status stand_object(RRep& rrep, const Stand& stand, Arena& arena);

}  // namespace plumbline::inline slicer
