#pragma once
/// The first reading of a mesh: how large it is, how many crossings it makes, and whether it is the surface of an object.

#include "slicer/core/numbers/vec.hpp"
#include "slicer/reader/triangles/triangle.hpp"

namespace plumbline::inline slicer {

/// Sums over all triangles, in rotated scan units.
struct MeshSurvey {
  Box3d bounds;  ///< of all usable triangles
  Box3d came;    ///< the same before the rotation
  double area = 0;
  double seen_area = 0;             ///< from above: the sum of the triangles' areas in the plane of the plate
  double cut_area = 0;              ///< the same of negative volumes, which nothing else here counts
  Vec3d directed = Vec3d::Zero();   ///< sum of areas times normals; 0 for a closed surface
  std::uint64_t most_vertices = 0;  ///< of a file
  std::uint64_t vertices = 0;
  std::uint64_t used_vertices = 0;
  std::uint64_t triangles = 0;

  /// Whether the faces of a file that also has points are the surface of an object. If not, it is a scan whose faces only join
  /// neighbouring points. They are if they use nearly all vertices, and if what is missing of the surface is small: the areas of a
  /// closed surface sum to 0 when they have the direction of its normals.
  bool is_object() const;
};

/// Makes the survey.
class Surveyor {
 public:
  explicit Surveyor(const Mat3d& rotation) : rotation_(rotation) {}
  /// @param negative  it is cut out of solids: it makes hits, but the object has its size without it
  void add(const Triangle& triangle, bool negative);
  void end_file(const MeshSummary& summary);
  const MeshSurvey& survey() const { return survey_; }

 private:
  Mat3d rotation_;
  MeshSurvey survey_;
};

}  // namespace plumbline::inline slicer
