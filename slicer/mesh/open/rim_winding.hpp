#pragma once
/// The winding number of a mesh by its hits and its open edges alone: exact, whatever the number of its triangles.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/mesh/mesh_lattice.hpp"

namespace plumbline::inline slicer {

/// The open edges of a mesh as one line of corners, each run from a corner to the next. The line goes to every loop and back on the same
/// way, so that what joins the loops cancels.
struct RimCorner {
  LatticePoint place;
  // Of the edge from here.
  Vec3f outward = Vec3f::Zero();  ///< normal of the surface at it
  bool joins = false;             ///< it leads to another loop
};
struct MeshRim {
  std::span<const RimCorner> corners;
  Vec3d step = Vec3d::Zero();  ///< of the lattice, mm
};

/// How much the surface at the rim leans outwards, seen from a place: numerator and denominator.
struct RimLean {
  float outwards = 0;
  float weight = 0;
};

/// A winding number: a whole number and the argument of re + i im, in (-pi, pi], divided by 2 pi.
struct WindingTurn {
  float re = 1, im = 0;
  std::int32_t whole = 0;

  void add(const WindingTurn& other);
  bool above_half() const { return whole > 0; }
  /// Whether the lean of the rim matters.
  bool is_near_half() const { return re < 0 && ((whole == 0 && im >= 0) || (whole == 1 && im < 0)); }
  /// Closes a hole with the curvature of the surface around it, as WindingTree::inside() does: W + c / 2 > 1/2.
  bool above_half(const RimLean& lean) const;
  bool above_tenth() const;
};

/// The winding number along one ray.
///
/// From each open edge a curtain hangs down for ever. Mesh and curtains together are closed but for a place infinitely far below. So the
/// hits of the ray above x, which passes no curtain, count how often both wind around x, and the winding number of the mesh is that
/// less the curtains':
///
///   W(x) = N(x) - 1 / (2 pi) sum_edges arg(p_a p_b + <a, b> + i (a_x b_y - a_y b_x))
///
/// a and b are from the ray to the edge's ends, level; p_a = |a - x| - (a - x)_z. An argument is half the solid angle of a
/// curtain (Van Oosterom and Strackee 1983, with one corner at the south pole). The arguments are added up by multiplying the numbers and
/// counting the full turns. So no function is needed that a library could round otherwise, and W > 1/2 is decided by the turns alone.
///
/// The side on which a ray passes an edge is that of its hits, in whole numbers (EdgeFunction).
class RimWinding {
 public:
  static std::size_t bytes_needed(std::size_t corners);
  /// @param rim    outlives this
  /// @param arena  bytes_needed() from the top
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<RimWinding> create(const MeshRim& rim, Arena& arena);

  /// Begins the ray through a pixel's centre.
  void begin(std::uint32_t pixel_column, std::uint32_t pixel_row);
  /// @param z      mm
  /// @param above  by the hits above: minus their sum
  WindingTurn at(float z, int above) const;
  /// Adds the lean of the normals along each loop, as seen from a place:
  ///
  ///   c(x) = sum_loops v_l c_l / sum_loops v_l,   v_l = sum_i l_i / r_i^3
  ///   c_l  = sum_i l_i / r_i * s_i (1 - s_i^4) / sum_i l_i / r_i,   r_i = |m_i - x|,   s_i = <n_i, m_i - x> / r_i
  ///
  /// l_i, m_i and n_i are length, middle and normal of an edge. In the middle of the missing cap of a sphere W is (1 - s) / 2, since
  /// all s_i are equal there; W + c / 2 is 1/2 up to s^4 / 2. Surface that turns its back to x (s = 1), like the walls of a box
  /// without its lid, does not count.
  void add_lean(float z, RimLean& lean) const;

 private:
  struct Edge {
    const LatticePoint &from, &to;
  };

  static std::size_t stride_of(std::size_t corners);
  std::span<float> column(std::size_t i) const { return room_.subspan(i * stride_, stride_); }
  Edge edge(std::size_t i) const;
  void place_edges();

  const MeshRim* rim_ = nullptr;
  std::span<float> room_;  ///< columns of stride_ numbers
  std::span<const std::uint32_t>
      ends_;                  ///< of each loop: the edge that leads to the next one, or behind the last corner
  std::span<double> places_;  ///< x, then y of stride_ + 1 corners, steps
  std::size_t stride_ = 0;    ///< a multiple of kLanes, at least kLanes more than there are edges
};

}  // namespace plumbline::inline slicer
