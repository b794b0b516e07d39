#pragma once
/// Finds the points of the object's surface, with their classes, normals and supports.

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/placement/floor_choice.hpp"
#include "slicer/placement/floor_plane.hpp"
#include "slicer/surface/clustering.hpp"
#include "slicer/surface/refined_normals.hpp"
#include "slicer/surface/stray_pieces.hpp"

namespace plumbline::inline slicer {

struct SurfaceSettings {
  NormalSource normals = NormalSource::kScanner;
  bool keep_strays = false;
  bool averaged = false;         ///< the points are means of neighbours, which need more evidence than a scan's
  bool may_average = false;      ///< there are enough points to average neighbours (again)
  FloorChoice floor;             ///< its height in coordinates of the cloud
  std::span<Vec3f> sample = {};  ///< room for points that the R-Rep is proven against; empty: for none
};

struct SurfacePoints {
  ClusteringResult clustering;  ///< epsilon and noise in units of the cloud
  StrayPieces strays;
  std::optional<FloorPlane> floor;  ///< that was cut off
  std::uint32_t floor_points = 0;   ///< left out with it
  Box3f floor_box;                  ///< around these
  std::uint32_t flying_points = 0;  ///< left out because they would have made the object larger
  std::uint32_t sampled = 0;        ///< points in SurfaceSettings::sample
  /// There is no surface, or one so much thicker than its neighbourhoods are wide that neighbours should be averaged first.
  bool blurred = false;

  /// Whether there is a surface. Where most points are outliers, the rest must have enough core points.
  bool found() const;
};

/// Calls cluster(), and what goes beyond the thesis: refine_normals(), rescue_sparse_surface(), mark_stray_pieces(), find_floor() and
/// mark_flying_points(), in that order. Estimated normals are turned over if the object on a floor faces inwards.
///
/// @param cloud  in the order of `tree`, with normals. On return noise points are gone, classes and supports are set. If the surface is
///               `blurred` the cloud keeps all of its points where they are
/// @param arena  work space of these functions from the top, released on return
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<SurfacePoints> find_surface_points(Cloud& cloud, const KdTree3& tree,
                                                          const SurfaceSettings& settings, Arena& arena,
                                                          const StageProgress& progress = {});

}  // namespace plumbline::inline slicer
