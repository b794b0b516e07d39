#pragma once
/// Which points are the object's surface, which way it faces there, and how far each of them counts.

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/bores/bore_walls.hpp"
#include "slicer/surface/clustering.hpp"
#include "slicer/surface/refined_normals.hpp"
#include "slicer/surface/stray_pieces.hpp"

namespace plumbline {

struct SurfaceSettings {
  ClusteringSettings clustering;
  NormalSource normals = NormalSource::kScanner;
  bool keep_strays = false;
};

struct SurfacePoints {
  ClusteringResult clustering;  ///< epsilon and noise in units of the cloud
  StrayPieces strays;
  BoreWalls bore_walls;

  /// Whether there is a surface at all; where most points are strays, whether what is left of them is one.
  bool found() const;
};

/// cluster() and what goes beyond the thesis from there: refine_normals(), rescue_sparse_surface(), mark_stray_pieces(),
/// widen_supports() and continue_bore_walls(), in that order. Estimated normals are fitted anew when supports are wider.
///
/// @param cloud  in the order of `tree`, with normals; on return noise is gone, classes and radius[] are set
/// @param arena  what those take from the top, given back
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Expected<SurfacePoints> find_surface_points(Cloud& cloud, const KdTree3& tree,
                                                          const SurfaceSettings& settings, Arena& arena,
                                                          const StageProgress& progress = {});

}  // namespace plumbline
