#pragma once
/// The raft below an object that is lifted.

#include <span>

#include "slicer/core/error.hpp"
#include "slicer/supports/strut_list.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::inline slicer {

/// A disc below every base, and bars between them along their minimum spanning tree (Prim 1957), so that all comes off in one
/// piece. The edges lean outwards by pad_wall_slope: a scraper gets below them. A net peels more easily than a plate while it is
/// printed, and takes less resin.
/// @param nearest  scratch, one for each pillar
[[nodiscard]] Status add_raft(const SupportSettings& settings, StrutList& list, std::span<double> nearest,
                              std::span<std::uint32_t> to);

}  // namespace plumbline::inline slicer
