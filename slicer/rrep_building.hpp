#pragma once
/// From the placed points of a surface to its R-Rep: the stages that slice() and inspect() share after placing.

#include <array>
#include <span>

#include "slicer/core/stage_scope.hpp"
#include "slicer/preparation.hpp"
#include "slicer/rrep/crossing_store.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/slice_report.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline::inline slicer {

/// A placed object once its rays have been shot.
struct ShotObject {
  CrossingStore store = {};  ///< at the bottom of the arena, its newest block
  /// Those of rays 1 to 3 of a pixel, below it in this order, if SliceSettings::grey is full.
  std::array<CrossingStore, kRaysAround> others = {};
  bool has_others = false;
  Placement placement = {};
  bool flat_underside = false;  ///< it stands on the base plane
  bool is_mesh = false;         ///< it is printed as it is, however small its parts are
  // Of a scan:
  ScanLengths<Millimetre> lengths = {};
  float support_points = 1;            ///< Cloud::support_points
  std::span<const Vec3f> sample = {};  ///< PreparedScan::sample, print coordinates
  float width_mm = 0;                  ///< w of thesis III-2.c
  RayCounts rays = {};
  ConfidenceMap confidence = {};  ///< at the bottom of the arena, below the crossings; empty unless asked for
};

/// Shoots a ray through each pixel that a scan can cover, or four.
/// @param scan  its cloud is consumed; work space is taken at the top of the arena and left to the caller
/// @retval ErrorCode::kOutOfMemory  before the first ray where the crossings that the surface will make don't fit
/// @retval ErrorCode::kCancelled
[[nodiscard]] Expected<ShotObject> shoot_rays(PlacedScan scan, const SliceSettings& settings, const StageContext& job);

/// Drops small components and small features of a scan, sorts the crossings by layer, and drops empty layers at both ends. If a pixel has four
/// rays, those of the first one decide what goes; the other three lose the same layers.
/// @param shot    its store is at the bottom of the arena, which the R-Rep takes over; nothing is at the top
/// @param report  gets what is known of the object, and keeps what was found before it was placed
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<RRep> finish_rrep(ShotObject& shot, const SliceSettings& settings, const StageContext& job,
                                         SliceReport& report);

}  // namespace plumbline::inline slicer
