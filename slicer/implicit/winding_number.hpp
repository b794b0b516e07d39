#pragma once
/// Generalized winding number of the oriented cloud: how often the sampled surface winds around a place. It is 1 inside and 0
/// outside, and changes smoothly across a hole in the scan.

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/implicit/dipole_tree.hpp"

namespace plumbline::inline slicer {

/// Numerator and denominator of c in WindingTree::inside(), divided by 4 pi.
struct WindingLean {
  static constexpr float kRounding = 0.3F;  ///< factor of c
  static constexpr float kMost = 0.12F;     ///< largest kRounding * |c|: s (1 - s^2) is at most 0.385

  float outwards = 0;
  float weight = 0;

  bool inside(float winding) const { return (winding - 0.5F) * weight + kRounding * outwards > 0; }
};

/// Whether an underside is open, by sections of the same samples: if the opening in the base plane has at least a tenth of the area of the
/// lowest section above it that is no smaller. If less is open, the underside was scanned and merely has holes.
/// @param count  count(0): samples on the base plane where the winding number is above 0.1, since it is 1/2 in an opening and 0 where
///               the underside is closed; count(k): those on the k-th section above it that are inside
template <class Count>
bool is_underside_open(Count count) {
  constexpr std::uint32_t kLeastOpen = 10;
  constexpr std::uint32_t kSections = 8;  // most sections compared
  const std::uint32_t open = count(0);
  // Outliers may lie below the object, and it may stand on a foot.
  std::uint32_t solid = 0;
  for (std::uint32_t k = 1; open > 0 && k <= kSections && solid < open; ++k) solid = count(k);
  return kLeastOpen * open > solid;
}

/// A hierarchy of dipoles over the cloud (Barill et al. 2018, eq. 6). Built once, then read by many threads.
///
///   W(x) = sum_i  a_i <n_i, p_i - x> / (4 pi |p_i - x|^3)
///
/// a_i is the area of point i, mm^2: that of the disc of its support radius, divided by the number of points in the disc.
class WindingTree {
 public:
  static constexpr float kSurface = 0.5F;  ///< value at the surface: halfway between outside and inside
  using Node = DipoleNode;

  static std::size_t nodes_needed(std::uint32_t points) { return Tree::nodes_needed(points); }
  /// Bytes of arena for that many points.
  static std::size_t bytes_needed(std::uint32_t points);

  /// @param cloud  placed, radius[] set, in the order of its 3D tree: 8 points in a row are a leaf
  /// @param nodes  nodes_needed(cloud.size) of them
  static WindingTree build(const Cloud& cloud, std::span<Node> nodes);

  /// Mirrors the surface and its normals at the plane z = height, if the underside is open (is_underside_open()). An opening there then counts as
  /// closed flat. A closed object on the plane is not affected, since outside of it its mirror image has winding number 0.
  ///
  /// @param height  mm
  /// @param reach   mm: sections two reaches apart are compared, from the plane upwards, beyond the supports of the points at the rim
  /// @param always  mirror without testing
  /// @returns whether the surface is mirrored
  bool set_base(float height, float reach, bool always = false);
  bool has_base() const { return has_base_; }
  /// Height of the base plane, mm: everything below is outside. -infinity without a base plane.
  float base() const { return has_base_ ? base_ : -std::numeric_limits<float>::infinity(); }

  /// @param x  print coordinates, mm
  /// @returns about 1 inside, 0 outside; below the base plane 0
  float operator()(const Vec3f& x) const { return number(x, 1); }
  /// The same within kRough away from all points, for a fraction of the time.
  float rough(const Vec3f& x) const { return number(x, kRoughShare); }
  static constexpr float kRough = 0.1F;
  /// Whether x is inside. A hole in the scan is closed with the curvature of the surface around it.
  ///
  /// W = 1/2 alone closes a hole flat, so a bulge with a hole would lose its cap. In the middle of the missing cap of a sphere,
  /// W is (1 - sin(t / 2)) / 2 if the normals along the rim lean outwards by t. The lean of the normals around x is
  ///   c(x) = sum_i a_i s_i (1 - s_i^2) / r_i^4  /  sum_i a_i / r_i^4,   r_i = |p_i - x|,   s_i = <n_i, p_i - x> / r_i
  /// The rim counts most; surface that faces x or turns its back to it (s = -1 or 1) does not count. W + 0.3 c is 1/2 within
  /// 0.01 in the middle of such a cap up to t = 12 degrees; beyond that, part of the cap is lost. In a hollow c is negative.
  bool inside(const Vec3f& x) const { return inside(x, operator()(x)); }
  /// @param winding  the winding number at x
  bool inside(const Vec3f& x, float winding) const;
  /// What inside() needs of c(x).
  WindingLean lean_at(const Vec3f& x) const;
  /// Whether a winding number is so far from 1/2 that a hole does not matter.
  static bool is_plain(float winding) { return std::abs(winding - kSurface) >= WindingLean::kMost; }

  /// Calls add(place, dipole, softening) for dipoles that make up the winding number at a place, or at every place in a box, with the
  /// mirror image of the surface: its sum of <dipole, place - x> / (|place - x|^2 + softening)^(3/2). The unit of dipoles is 4 pi mm^2.
  /// @param at  Vec3f or Box3f
  template <class Place, class Add>
  void for_each_dipole(const Place& at, Add add) const {
    walk(at, add, 1);
    if (!has_base_) return;
    // The mirrored surface seen from a place is the surface seen from the mirror image of the place.
    const auto add_mirrored = [&](const Vec3f& place, const Vec3f& dipole, float softening) {
      add(mirrored(place), Vec3f(dipole[0], dipole[1], -dipole[2]), softening);
    };
    walk(mirrored(at), add_mirrored, 1);
  }

 private:
  using Tree = DipoleTree<8>;

  /// mm^2
  float area_of(std::uint32_t i) const {
    return area_factor_ * cloud_.radius[i] * cloud_.radius[i] * static_cast<float>(cloud_.normal[i].weight);
  }
  /// Added to the square of the distance of point i, mm^2. Without it a dipole would grow without bound nearby, where a disc
  /// fills at most half the sphere. It is half the square of the radius of one scan point's disc; all of it would blur walls
  /// that only the winding number places (slicer/EXPERIMENTS.md).
  float softening_of(std::uint32_t i) const {
    constexpr float kShare = 0.5F;
    return kShare * cloud_.radius[i] * cloud_.radius[i] * area_factor_ * std::numbers::inv_pi_v<float>;
  }

  Vec3f mirrored(const Vec3f& p) const { return {p[0], p[1], 2 * base_ - p[2]}; }
  Box3f mirrored(const Box3f& box) const {
    Box3f mirror;
    mirror.extend(mirrored(box.low));
    mirror.extend(mirrored(box.high));
    return mirror;
  }

  template <class Place, class Add>
  void walk(const Place& at, Add add, float share) const {
    tree_.walk(
        at, [&](const Node& node) { add(node.centre, node.dipole, 0.0F); },
        [&](std::uint32_t i) {
          add(cloud_.position[i], Vec3f(cloud_.normal[i].unpack() * (area_of(i) * kInverse4Pi)), softening_of(i));
        },
        share);
  }

  static constexpr float kInverse4Pi = 0.25F * std::numbers::inv_pi_v<float>;

  float number(const Vec3f& x, float share) const;

  Tree tree_;
  Cloud cloud_;
  float area_factor_ = 0;  ///< area of a scan point / its radius squared
  float base_ = std::numeric_limits<float>::lowest();
  bool has_base_ = false;
};

}  // namespace plumbline::inline slicer
