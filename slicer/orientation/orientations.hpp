#pragma once
/// Which way up an object is printed best, and whether a scan lies wrong.

#include <array>
#include <cstddef>
#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/orientation/clean_side.hpp"
#include "slicer/orientation/surface_samples.hpp"

namespace plumbline::inline slicer {

/// What an orientation costs. Areas and lengths in the unit of the cloud.
struct OrientationCost {
  double support_area =
      0;  ///< that faces down more steeply than 45 degrees and does not stand on the plate, as seen from below
  double support_volume = 0;  ///< between that area and the plate
  double peel_area = 0;       ///< of the largest layer
  double height = 0;
  double scar_area = 0;   ///< support_area, weighted by how well it was seen: supports leave scars there
  double clean_area = 0;  ///< support_area on the side that is to stay clean, weighted by how squarely it faces there
  double foot_area = 0;  ///< that stands on the plate; the hole too, if it faces down to 10 degrees. Else it hangs over
  /// Without unit: 2 support_area / A + support_volume / A^1.5 + peel_area / A + 0.15 height / sqrt(A) + scar_area / A + 20 clean_area / A,
  /// and the share of the hole in A, times 1 - <down, way the hole faces>. A is the surface's area.
  double total = 0;
};

/// Cosine of 35 degrees, the default of support_overhang_angle: a surface whose normal points down more steeply needs supports.
inline constexpr float kNeedsSupport = 0.81915204F;

struct Orientation {
  std::array<double, 2> degrees = {};  ///< about x, then about y: --rotate-x, --rotate-y
  OrientationCost cost;
};

/// @param samples  of the scan as it came
/// @param degrees  about x, then about y
OrientationCost cost_of(const SurfaceSamples& samples, const std::array<double, 2>& degrees,
                        CleanSide clean = CleanSide::kNone);

inline constexpr std::size_t kBestOrientations = 4;
/// The first is the scan as it came, the others are the best that differ from it and from each other, the best first.
using WaysUp = std::array<Orientation, 1 + kBestOrientations>;

/// Compares 288 directions, 15 degrees apart, and refines the best to a tenth of a degree, so that flat faces stand flat. A tilt adds 0.5 (1 - cos)
/// to the total, 0.1 (1 - cos) on a flat foot; upright is the scan as it came, or better_upright(). Proposals differ by 30 degrees or more from each
/// other, and by 20 or more from the scan as it came. A nearer one is proposed only if it costs less than three quarters as much, such as the
/// way in which a scan that leans by 10 degrees stands flat.
/// @param samples  of the scan as it came
/// @param clean    supports' scars on that side cost much more
/// @returns none if progress says to stop
std::optional<WaysUp> best_orientations(const SurfaceSamples& samples, CleanSide clean, const StageProgress& progress);

/// A rotation by quarter turns that puts a scan upright which plainly is not: the one that costs least, if it costs less than three
/// quarters of what the present one does, and if there is evidence: the hole faces down there and not now, or the object
/// stands on a flat foot there and not now.
std::optional<Orientation> better_upright(const SurfaceSamples& samples);

}  // namespace plumbline::inline slicer
