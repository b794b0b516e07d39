#pragma once
/// Which way up an object is printed best, and whether a scan lies wrong.

#include <array>
#include <cstddef>
#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/orientation/surface_samples.hpp"

namespace plumbline::inline slicer {

/// What an orientation costs. Areas and lengths in the unit of the cloud.
struct OrientationCost {
  double support_area =
      0;  ///< that faces down more steeply than 45 degrees and does not stand on the plate, as seen from below
  double support_volume = 0;  ///< between that area and the plate
  double peel_area = 0;       ///< of the largest layer
  double height = 0;
  double scar_area = 0;  ///< support_area, weighted by how well it was seen: supports leave scars there
  double foot_area = 0;  ///< that stands on the plate; the hole too, if it faces down to 10 degrees. Else it hangs over
  /// Without unit: 2 support_area / A + support_volume / A^1.5 + peel_area / A + 0.15 height / sqrt(A) + scar_area / A, and the
  /// share of the hole in A, times 1 - <down, way the hole faces>. A is the surface's area.
  double total = 0;
};

struct Orientation {
  std::array<double, 2> degrees = {};  ///< about x, then about y: --rotate-x, --rotate-y
  OrientationCost cost;
};

/// @param degrees  about x, then about y
OrientationCost cost_of(const SurfaceSamples& samples, const std::array<double, 2>& degrees);

inline constexpr std::size_t kBestOrientations = 4;

/// The upright way is the one in which the object lies, or that of better_upright(): what it is tilted by costs extra, 0.5 (1 - cos) in the total, 0.1 on
/// a flat foot. The best of 288 directions 15 degrees apart, each refined to a tenth of a degree: flat faces stand flat. The best comes first; two
/// of them differ by 30 degrees or more.
/// @returns none if progress says to stop
std::optional<std::array<Orientation, kBestOrientations>> best_orientations(const SurfaceSamples& samples,
                                                                            const StageProgress& progress);

/// The best way up of a surface with normals.
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<Orientation> best_way_up(const Cloud& cloud, Arena& arena, const StageProgress& progress);

/// A rotation by quarter turns that puts a scan upright which plainly is not: the one that costs least, if it costs less than three
/// quarters of what the present one does, and if there is evidence: the hole faces down there and not now, or the object
/// stands on a flat foot there and not now.
std::optional<Orientation> better_upright(const SurfaceSamples& samples);

}  // namespace plumbline::inline slicer
