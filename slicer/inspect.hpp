#pragma once
/// Measures a scan and slices it coarsely, to predict the result of slice().

#include "slicer/core/arena.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/numbers/length.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/slice_report.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline::inline slicer {

/// The findings of prepare(), further measurements of the scan, and the report of the coarse slice.
struct InspectReport : PreparationReport {
  ScanLengths<ScanUnit> lengths;
  Box3d bounds;                ///< of the rotated scan without its noise points and stray pieces, scan units
  Box3d bounds_with_noise;     ///< of the rotated scan, scan units
  Vec3d came = Vec3d::Zero();  ///< sides of the figure as it came, before any rotation, scan units: what a size means
  ScanLength spacing;          ///< median distance of a point from the nearest other one
  ScanLength roughness;        ///< median distance of a point from the plane through its kPlaneNeighbours nearest
  Units units = Units::kMillimetres;  ///< the unit asked for, or the guess
  /// As in slice(), or why the object doesn't fit. Its layers are those that the coarse R-Rep has.
  Expected<Placement> placement;
  Status sliced;       ///< why there is no coarse R-Rep: ErrorCode::kNoSurface (a speck), kOutOfMemory or kDoesNotFit
  SliceReport coarse;  ///< of the coarse R-Rep; its confidence map is released together with it
};

/// Neighbours that the plane for the roughness is fitted to. Few, so that the object's own curvature hardly counts.
inline constexpr std::uint32_t kPlaneNeighbours = 24;

/// Pixels of the coarse R-Rep along the object's longest side. More see smaller holes of the scan and cost more time. Its
/// layers are as high as in slice().
inline constexpr double kCoarsePixels = 160;

/// Called with the coarse R-Rep, which is released when the call returns.
using CoarseLook = FunctionRef<Status(const RRep& rrep, const SliceReport& report)>;
inline constexpr auto kNoLook = [](const RRep&, const SliceReport&) -> Status { return {}; };

/// Reads a scan, prepares and measures it, and slices it coarsely. The arena is as before when it returns.
/// @param sources   1 to kMostScans files of one frame, each read once from start to end, in this order
/// @param settings  as for slice(); a confidence map is always kept
/// @param report    filled as far as it went, also on error
/// @param look      called once if there is a coarse R-Rep
/// @retval ErrorCode::kNoSurface  there is none, so nothing could be measured: in the words of slice()
/// @retval ErrorCode::kOutOfMemory, kCancelled and all of read_scan() and `look`
[[nodiscard]] Status inspect(ScanSources sources, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                             InspectReport& report, CoarseLook look = kNoLook);

}  // namespace plumbline::inline slicer
