#pragma once
/// The slicer from end to end: scan bytes in, R-Rep out (DESIGN section 3). One call a stage, none reaches back.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/layers/layer_features.hpp"
#include "slicer/normals/normals.hpp"
#include "slicer/placement/base_choice.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/rays/ray_shooter.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/reader/stream/scan_point.hpp"
#include "slicer/rrep/components.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/surface/bores/bore_walls.hpp"
#include "slicer/surface/clustering.hpp"
#include "slicer/surface/stray_pieces.hpp"
#include "slicer/views/align_views.hpp"

namespace plumbline {

struct SliceSettings {
  PlacementSettings placement;
  ClusteringSettings clustering;
  BaseChoice base = BaseChoice::kAuto;
  bool confidence = false;    ///< keep a map of what the surface rests on
  bool keep_all = false;      ///< stray pieces, too
  std::uint32_t threads = 1;  ///< 1 to 64; the masks do not depend on it
};

/// What happened, in numbers.
struct SliceReport {
  ScanSummary scan;                   ///< of all files: sum_of()
  ScanSummaries scans;                ///< of each file
  std::uint32_t cloud_capacity = 0;   ///< points the arena has room for
  std::uint32_t cloud_points = 0;     ///< points after thinning
  double thinning_cell_mm = 0;        ///< 0: none
  std::uint64_t averaged_points = 0;  ///< scan points that were averaged into another
  Units units = Units::kMillimetres;  ///< used
  bool units_guessed = false;
  NormalCounts normals;
  ViewAlignment views;          ///< lengths in mm
  ClusteringResult clustering;  ///< epsilon in mm
  StrayPieces strays;           ///< left out before the object was placed
  BoreWalls bore_walls;         ///< continued; area in mm^2
  float width_mm = 0;           ///< w
  Placement placement;
  bool flat_underside = false;  ///< it stands on the base plane
  RayCounts rays;
  ComponentCounts components;
  FeatureCounts features;
  std::uint64_t crossings = 0;
  ConfidenceMap confidence;  ///< in the arena below the R-Rep, and as long as that; empty where none was asked for
  std::array<std::size_t, kStageCount> planned_bytes = {};  ///< of the arena, by Stage
  std::array<std::size_t, kStageCount> peak_bytes = {};     ///< of the arena, by Stage
};

/// Reads a scan and builds its R-Rep at the bottom of the arena. When it returns the top of the arena is as before.
/// @param sources  1 to kMostScans files of one frame, each read once from start to end, in this order
/// @param report  filled as far as it went, also on error
/// @retval ErrorCode::kOutOfMemory  before the scan is read where its header and the printer's grid tell; else by the stage
/// @retval ErrorCode::kDoesNotFit, kNoPoints, kNoSurface, kCancelled and all of read_scan()
[[nodiscard]] Expected<RRep> slice(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                   ProgressSink* progress, SliceReport& report);
[[nodiscard]] inline Expected<RRep> slice(ByteSource& source, const SliceSettings& settings, Arena& arena,
                                          ProgressSink* progress, SliceReport& report) {
  ByteSource* const one[] = {&source};
  return slice(ScanSources(one), settings, arena, progress, report);
}

}  // namespace plumbline
