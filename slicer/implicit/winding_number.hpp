#pragma once
/// Generalized winding number of the oriented cloud: how often the surface that the points sample goes round a place.
/// 1 inside, 0 outside, smoothly between across a hole in the scan: the evidence of DESIGN 3, stage 7e.

#include <cstdint>
#include <limits>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/implicit/dipole_tree.hpp"

namespace plumbline {

/// A hierarchy of dipoles over the cloud (Barill et al. 2018, eq. 6), built once, read by many threads.
///
///   W(x) = sum_i  a_i <n_i, p_i - x> / (4 pi |p_i - x|^3)
///
/// a_i, the area of point i, is that of the disc of its radius divided by the points that the disc holds.
class WindingTree {
 public:
  static constexpr std::uint32_t kLeafPoints = 8;
  static constexpr float kSurface = 0.5F;  ///< its value on the surface, where that is open: halfway between out and in
  using Node = DipoleNode;

  static std::size_t nodes_needed(std::uint32_t points) { return Tree::nodes_needed(points); }
  /// Bytes of arena for that many points.
  static std::size_t bytes_needed(std::uint32_t points);

  /// @param cloud  placed, radius[] set, in the order of its 3D tree: 8 points in a row are a leaf
  /// @param support_points  that radius[] was made for
  /// @param nodes  nodes_needed(cloud.size) of them
  static WindingTree build(const Cloud& cloud, float support_points, std::span<Node> nodes);

  /// Mirrors the surface at the plane z = height, normals too: what is open there counts as closed flat (a closed object
  /// standing on the plane is left as it is, since outside of it its mirror image counts nothing).
  /// @param step    mm: the lowest section of the object, for comparison with what is open at the plane, is looked for so far
  ///                above it, twice as far, and on
  /// @param always  mirror it whether it is open there or not
  /// @returns whether it is mirrored: where less than a tenth is open the underside was seen, and has holes at most
  bool set_base(float height, float step, bool always = false);
  bool has_base() const { return has_base_; }
  /// mm; nothing is inside below. -infinity without one.
  float base() const { return has_base_ ? base_ : -std::numeric_limits<float>::infinity(); }

  /// @param x  print coordinates, mm
  /// @returns about 1 inside, 0 outside; below the base plane 0
  float operator()(const Vec3f& x) const;
  /// Whether x is inside, where a hole of the scan is closed as round as the surface about it.
  ///
  /// Where W is 1/2 a hole is closed flat, and a bulge with a hole in it has lost its cap. Seen from the middle of the missing
  /// cap of a sphere, W is (1 - sin(t / 2)) / 2 if the normals along the rim lean t outwards. How far those round x lean
  /// outwards is
  ///   c(x) = sum_i a_i s_i (1 - s_i^2) / r_i^4  /  sum_i a_i / r_i^4,   r_i = |p_i - x|,   s_i = <n_i, p_i - x> / r_i
  /// which counts the rim most, and of what faces x or turns its back to it (s = -1, 1: no rim) nothing. So W + 0.3 c is 1/2
  /// in the middle of such a cap, within 0.01 up to t = 12 degrees; beyond, part of the cap stays lost. In a hollow c is
  /// negative.
  bool inside(const Vec3f& x) const;
  /// Where the vertical line at (x, y) goes through the surface between two depths, of which one is inside, by bisection.
  /// @param from, to   mm, either of them the lower
  /// @param tolerance  mm: no nearer than that, nor than a 256th of the way
  float surface_between(float x, float y, float from, float to, bool inside_at_from, float tolerance) const;

 private:
  using Tree = DipoleTree<kLeafPoints>;

  /// What c of inside() is the quotient of, over 4 pi.
  struct Lean {
    float outwards = 0;
    float weight = 0;
  };

  float sum(const Vec3f& x) const;
  void add_lean(const Vec3f& x, Lean& lean) const;

  Tree tree_;
  std::span<const Vec3f> position_;
  std::span<const PackedNormal> normal_;
  std::span<const float> radius_;
  float area_factor_ = 0;  ///< area of a point over its radius squared
  float base_ = std::numeric_limits<float>::lowest();
  bool has_base_ = false;
};

}  // namespace plumbline
