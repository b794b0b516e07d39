#pragma once
/// A few thousand patches that stand for the surface of a scan, and the hole that nobody scanned.

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline slicer {

/// A patch of the surface; unit of the cloud.
struct SurfaceSample {
  Vec3f position = Vec3f::Zero();
  Vec3f normal = Vec3f::UnitZ();  ///< unit length
  float area = 0;
  float quality = 1;  ///< density of the points over that of the whole scan, at most 2: how well it was seen
};

/// All patches, and what of a closed surface is missing.
struct SurfaceSamples {
  std::span<const SurfaceSample> patches;  ///< none: no point has a normal
  float cell = 0;                          ///< side of a patch
  float area = 0;                          ///< of all patches
  /// Outward normal times area of the hole: the area vectors of a closed surface sum to zero, so it is minus their sum.
  Vec3f hole = Vec3f::Zero();

  float hole_share() const;  ///< of the area
  /// Patches make up to a share of 0.05 of a closed surface.
  bool has_hole() const { return hole_share() > 0.06F; }
};

/// Arena bytes that sample_surface() takes for a cloud of `points`.
std::size_t sample_surface_bytes(std::uint32_t points);

/// Sorts at most 131,072 points into cells, a patch for each way that the surface in a cell faces. The area of a patch with
/// normal n is that of a plane in a cell on average, cell^2 / (|n_x| + |n_y| + |n_z|). Cells with few points are left out.
/// @param cloud  at least one point; classes are not used
/// @param arena  the patches stay at its top, with sample_surface_bytes() of work space
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<SurfaceSamples> sample_surface(const Cloud& cloud, Arena& arena);

}  // namespace plumbline::inline slicer
