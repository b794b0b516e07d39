#pragma once
/// Negative volumes: what a project cuts out of its solids.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/numbers/vec.hpp"
#include "slicer/mesh/hit_list.hpp"
#include "slicer/mesh/mesh_lattice.hpp"
#include "slicer/mesh/ray_solids.hpp"

namespace plumbline::inline slicer {

/// Cuts the negative volumes out of what is solid on a ray: a place stays solid if it is in a solid of an item that has none there. Where no
/// hits but the winding number say that a place is solid, all items' negative volumes count.
/// @param solid     layers at which the ray becomes solid, then empty, and so on
/// @param hits      of the ray
/// @param negative  of its negative volumes, packed as `hits`
/// @param toggles   gets what is left
void cut_negative(std::span<const std::uint16_t> solid, const RayHits& hits, std::span<const PackedHit> negative,
                  std::uint32_t layers, RayToggles& toggles);

/// Cuts a triangle to the grid, for it may reach beyond it: what lies above or below is moved to the grid's end along the rays.
class GridClipper {
 public:
  /// @param last  steps to the far corner of the grid
  explicit GridClipper(const Vec3d& last) : last_(last) {}

  /// Calls visit(LatticeTriangle) for each part. Two triangles that share an edge have the same corners along it afterwards.
  /// @param corners  steps of the lattice
  template <class Visit>
  void clip(const std::array<Vec3d, 3>& corners, Visit visit) {
    Polygon level;
    for (const Vec3d& corner : corners) level.add(corner);
    for (const int axis : {0, 1}) level = above(above(level, axis, 0, 1), axis, last_[axis], -1);
    const Polygon over = above(level, 2, last_[2], 1);
    const Polygon inside = above(above(level, 2, last_[2], -1), 2, 0, 1);
    const Polygon under = above(level, 2, 0, -1);
    for (const Polygon* part : {&under, &inside, &over}) {
      for (std::size_t i = 2; i < part->count; ++i) {
        visit(LatticeTriangle{rounded(part->corner[0]), rounded(part->corner[i - 1]), rounded(part->corner[i])});
      }
    }
  }

 private:
  struct Polygon {
    std::array<Vec3d, 10> corner;  ///< three, and one more for each plane that cuts
    std::size_t count = 0;
    void add(const Vec3d& p) { corner[count++] = p; }
  };

  /// What lies on one side of a plane: sign * (p[axis] - at) >= 0.
  static Polygon above(const Polygon& polygon, int axis, double at, double sign);
  LatticePoint rounded(const Vec3d& p) const;

  Vec3d last_;
};

}  // namespace plumbline::inline slicer
