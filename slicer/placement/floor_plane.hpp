#pragma once
/// Finds the floor or turntable that an object was scanned on.

#include <optional>

#include "slicer/cloud/cloud.hpp"

namespace plumbline::inline slicer {

/// A plane that is the floor with everything less than `margin` above it.
struct FloorPlane {
  Vec3f normal = Vec3f::UnitZ();  ///< up
  float offset = 0;               ///< <normal, p> of its points p, unit of the cloud
  float margin = 0;               ///< unit of the cloud

  bool cuts(const Vec3f& p) const { return normal.dot(p) - offset < margin; }
};

/// Finds a plane that the object stands on. It is a floor only if all of this holds, so flat undersides, plates with letters and
/// plinths are none:
///   - it is level to 10 degrees, faces up (if `sides_known`), and has a twentieth of the points,
///   - nothing was scanned below it, since a plate or a plinth has walls there, and an underside; or it is a turntable: a disc, much wider than
///     the object, with nothing below it but a wall at its edge,
///   - it reaches beyond the object on three sides or more, and a quarter of it is free of the object,
///   - the object on it is at least a quarter as high as it is wide: letters and reliefs are lower.
/// @param cloud    with normals; points of class kNoise are not used
/// @param epsilon  ClusteringResult::epsilon, above 0
/// @param noise    ClusteringResult::noise
/// @param sides_known  normals are the scanner's. Of an estimated one the side is a guess: a plane with a ball on it has no outer side
std::optional<FloorPlane> find_floor(const Cloud& cloud, float epsilon, float noise, bool sides_known);

/// The rotation about a horizontal axis that turns a unit vector to +z.
/// @param up  not -z
Mat3d levelling(const Vec3d& up);

}  // namespace plumbline::inline slicer
