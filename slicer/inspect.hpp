#pragma once
/// A look at a scan without slicing it: its first stages, and what the others would need.

#include <array>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/normals/normals.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/plan/memory_plan.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/surface/clustering.hpp"
#include "slicer/surface/stray_pieces.hpp"

namespace plumbline {

struct InspectSettings {
  PlacementSettings placement;  ///< its rotation and its printer; units and scale change no result
  ClusteringSettings clustering;
  bool keep_all = false;      ///< stray pieces count as part of the object
  std::uint32_t threads = 1;  ///< 1 to 64; the result does not depend on it
};

/// Lengths are scan units: what a unit is, the scan does not say.
struct InspectReport {
  ScanSummary scan;                   ///< of all files: sum_of()
  ScanSummaries scans;                ///< of each file
  std::uint32_t cloud_capacity = 0;   ///< points the arena has room for
  std::uint32_t cloud_points = 0;     ///< points after thinning
  double thinning_cell = 0;           ///< 0: all points fit
  std::uint64_t averaged_points = 0;  ///< scan points that were averaged into another
  NormalCounts normals;
  Box3d bounds;                 ///< of the rotated scan without its noise and stray pieces
  Box3d bounds_with_noise;      ///< of the rotated scan
  double spacing = 0;           ///< median distance of a point from the nearest other one
  double roughness = 0;         ///< median distance of a point from the plane through its kPlaneNeighbours nearest
  ClusteringResult clustering;  ///< epsilon and noise in scan units
  StrayPieces strays;           ///< that slice() would leave out
  std::array<std::size_t, kStageCount> peak_bytes = {};  ///< of the arena, by Stage
};

/// Neighbours that a plane is laid through. Few, so that the object's own curvature counts for little.
inline constexpr std::uint32_t kPlaneNeighbours = 24;

/// Reads a scan and measures it. The arena is as before when it returns.
/// @param sources  1 to kMostScans files of one frame, each read once from start to end, in this order
/// @param report  filled as far as it went, also on error
/// @retval ErrorCode::kOutOfMemory, kCancelled and all of read_scan()
[[nodiscard]] Status inspect(ScanSources sources, const InspectSettings& settings, Arena& arena, ProgressSink* progress,
                             InspectReport& report);

}  // namespace plumbline
