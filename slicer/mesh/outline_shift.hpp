#pragma once
/// Moves the corners of a mesh so that the outlines of its layers move by a given length.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/mesh/mesh_lattice.hpp"

namespace plumbline::inline slicer {

/// A table of a mesh's corners and their moves. Corners of several triangles in one place are one corner, so what is closed stays closed.
///
/// Each face's plane is to move by `by` along its horizontal normal, which is by |n_xy| along its normal n. For a corner that is the move d
/// of least squares, over the faces that meet there,
///
///     n . d = by |n_xy|,    weighted by the sine of the face's angle at the corner
///
/// and the shortest such d where the faces leave a direction free: a wall moves along its normal, the edge of two walls to where their moved
/// planes meet, and no level face moves up or down. A sharp edge moves by kMitre times `by` at most.
class OutlineShift {
 public:
  /// Of PrusaSlicer's offsets, which are Clipper's.
  static constexpr double kMitre = 3;

  static std::size_t bytes_needed(std::uint64_t triangles);
  /// @param arena  bytes_needed() from the top
  [[nodiscard]] static Expected<OutlineShift> create(std::uint64_t triangles, Arena& arena);

  void clear();
  /// @param corners   of a triangle, not moved
  /// @param print_mm  the same before they were rounded
  /// @returns false: there are more corners than room, more than seven for ten triangles
  [[nodiscard]] bool add(const LatticeTriangle& corners, const std::array<Vec3d, 3>& print_mm);
  /// After the last triangle.
  /// @param by_mm  outwards if above 0
  /// @param step   MeshLattice::step()
  void solve(double by_mm, const Vec3d& step);

  /// Steps by which a corner moves, after solve(); 0 if no triangle with an area has it.
  std::array<std::int64_t, 3> move_of(const LatticePoint& corner) const;

 private:
  struct Corner {
    LatticePoint at;          ///< x below 0: the slot is free
    std::array<float, 6> nn;  ///< sums of the weighted n n': xx, xy, xz, yy, yz, zz
    Vec3f n;                  ///< sum of the weighted |n_xy| n; after solve() the move, steps
  };

  /// The slot of a corner, or the free one where it belongs.
  Corner& slot_of(const LatticePoint& corner) const;

  std::span<Corner> slots_;
  std::size_t used_ = 0;
};

}  // namespace plumbline::inline slicer
