#pragma once
/// The ways up that are proposed for a print, with what each takes: supports are found for each of them on a coarse model.

#include <array>
#include <cstdint>
#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/orientation/orientations.hpp"
#include "slicer/orientation/surface_samples.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline::inline slicer {

/// A way up, at the size that the print has.
struct WayUp {
  std::array<double, 2> degrees = {};  ///< about x, then about y
  OrientationCost cost;                ///< unit of the cloud; the total has the supports that were found as well
  double unit_mm = 1;                  ///< mm of the print in the unit of the cloud
  double height_mm = 0;                ///< of the object
  std::uint32_t layers = 0;            ///< of the print, with the elevation
  /// Of the supports that a print would have, on the coarse model.
  struct Supports {
    std::uint32_t tips = 0;
    double scar_mm2 = 0;    ///< where tips touch the object
    double clean_mm2 = 0;   ///< the share of it on the side that is to stay clean
    double volume_mm3 = 0;  ///< of supports and raft
  };
  std::optional<Supports> supports;  ///< none: nobody wants any, or the arena has no room to find them
};

/// The first is the scan as it came, the others differ from it and from each other, the best first.
using PrintedWays = std::array<WayUp, 1 + kBestOrientations>;

/// The one that costs least: the scan as it came if none is better.
const WayUp& cheapest(const PrintedWays& ways);

/// Finds them. All have the size of the figure as it came; only with PlacementSettings::fit each is as large as fits. Supports are counted
/// on a model of 128 voxels along the longest side (coarse_model.hpp), which loses thinner walls. All five take some three seconds of CPU time on a desktop.
/// @param cloud     of the scan as it came, with normals: tells sizes more exactly than the samples
/// @param samples   of `cloud`
/// @param settings  of the print: placement, with the unit that the format fixes and only the rotation about z; keep_clean; supports
/// @retval ErrorCode::kCancelled  progress said so
[[nodiscard]] Expected<PrintedWays> find_ways_up(const Cloud& cloud, const SurfaceSamples& samples,
                                                 const SliceSettings& settings, Arena& arena,
                                                 const StageProgress& progress);

/// The best way up of a surface with normals, as find_ways_up() says.
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<Orientation> best_way_up(const Cloud& cloud, const SliceSettings& settings, Arena& arena,
                                                const StageProgress& progress);

}  // namespace plumbline::inline slicer
