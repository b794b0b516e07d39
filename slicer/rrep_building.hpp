#pragma once
/// From the placed points of a surface to its R-Rep: the stages that slice() and inspect() share after placing.

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/rrep/crossing_store.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/slice_report.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline {

/// Shoots a ray through each pixel that the object can cover.
/// @param cloud   print coordinates, mm; at the top of the arena, where work space is taken and left to the caller
/// @param report  placement, lengths, clustering and cloud_points are read; the results of the rays are set. Its
///                confidence map is at the bottom of the arena, below the crossings
/// @retval ErrorCode::kOutOfMemory  before the first ray where the crossings that the surface will make don't fit
/// @retval ErrorCode::kCancelled
[[nodiscard]] Expected<CrossingStore> shoot_rays(Cloud& cloud, const SliceSettings& settings, Arena& arena,
                                                 ProgressSink* progress, SliceReport& report);

/// Drops small components and small features, sorts the crossings by layer, and drops empty layers at both ends.
/// @param store  at the bottom of the arena, which the R-Rep takes over; nothing is at the top
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<RRep> finish_rrep(CrossingStore& store, const SliceSettings& settings, Arena& arena,
                                         ProgressSink* progress, SliceReport& report);

}  // namespace plumbline
