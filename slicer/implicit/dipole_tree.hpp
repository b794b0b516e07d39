#pragma once
/// A hierarchy of dipoles over the points of a cloud (Barill et al., Fast Winding Numbers for Soups and Clouds, 2018, first
/// order). Seen from far away, the points of a node act as one dipole at their centre.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

inline constexpr float kRoughShare = 0.39F;  ///< of DipoleTree::walk(): nodes are opened up to 1.25 radii

struct DipoleNode {
  Vec3f centre;            ///< mean position of the points, weighted by area, mm
  float reach2 = 0;        ///< (opening * radius)^2, mm^2: beyond it the node acts as one dipole; -1: it has no points
  Vec3f dipole;            ///< sum of a_i n_i / (4 pi), mm^2
  std::uint32_t skip = 0;  ///< index of the next node if this one is not opened
};

/// Sums over the points of a node.
struct DipoleSum {
  Vec3f weighted = Vec3f::Zero();  ///< area * position
  Vec3f dipole = Vec3f::Zero();
  float area = 0;
  Box3f box;

  /// @param point_area    in any unit that is the same for all points
  /// @param point_dipole  mm^2
  void add(const Vec3f& position, float point_area, const Vec3f& point_dipole) {
    weighted += position * point_area;
    dipole += point_dipole;
    area += point_area;
    box.extend(position);
  }
  void add(const DipoleSum& other) {
    weighted += other.weighted;
    dipole += other.dipole;
    area += other.area;
    box.low = box.low.cwiseMin(other.box.low);
    box.high = box.high.cwiseMax(other.box.high);
  }
};

/// The nodes in depth-first order: a node is followed by its descendants, up to `skip`. The points must be in the order of
/// their 3D tree, so that LeafPoints in a row are neighbours and make a leaf. A subtree over n leaves has 2 n - 1 nodes.
template <std::uint32_t LeafPoints>
class DipoleTree {
 public:
  static std::size_t nodes_needed(std::uint32_t points) {
    return points == 0 ? 0 : std::size_t{leaves(points)} * 2 - 1;
  }

  DipoleTree() = default;
  /// @param nodes  nodes_needed(points) of them
  DipoleTree(std::uint32_t points, std::span<DipoleNode> nodes) : points_(points), nodes_(nodes) {}

  /// @param add_point  add_point(i, sum): adds point i to the DipoleSum, or leaves it out
  template <class AddPoint>
  void build(AddPoint add_point) {
    if (points_ > 0) build(0, 0, leaves(points_), add_point);
  }

  /// Visits the nodes and points that make up the field at a place, or at every place in a box, in the order of the nodes.
  /// Thread-safe.
  /// @param place  Vec3f or Box3f
  /// @param far    far(node) for each node that acts as one dipole at all of these places
  /// @param near   near(i) for each point of a leaf that is too close for that
  /// @param share  of the distance at which a node is no longer opened, squared: less is faster and less exact
  template <class Place, class Far, class Near>
  void walk(const Place& place, Far far, Near near, float share = 1) const {
    const auto count = static_cast<std::uint32_t>(nodes_.size());
    std::uint32_t leaf = 0;  // number of leaves before node `at`
    for (std::uint32_t at = 0; at < count;) {
      const DipoleNode& node = nodes_[at];
      const std::uint32_t under = (node.skip - at + 1) / 2;
      const Vec3f d = shortest_way(place, node.centre);
      if (d.dot(d) > share * node.reach2) {
        if (node.reach2 >= 0) far(node);
        leaf += under;
        at = node.skip;
      } else if (under > 1) {
        ++at;
      } else {
        const std::uint32_t last = std::min(points_, (leaf + 1) * LeafPoints);
        for (std::uint32_t i = leaf * LeafPoints; i < last; ++i) near(i);
        ++leaf;
        ++at;
      }
    }
  }

 private:
  static constexpr float kOpening = 2.0F;  ///< node radii: a closer node is opened. Larger: more exact, slower

  static Vec3f shortest_way(const Vec3f& place, const Vec3f& to) { return to - place; }
  /// But for the signs.
  static Vec3f shortest_way(const Box3f& box, const Vec3f& to) {
    return (box.low - to).cwiseMax(to - box.high).cwiseMax(0.0F);
  }

  static std::uint32_t leaves(std::uint32_t points) { return (points + LeafPoints - 1) / LeafPoints; }

  /// Builds node `at` over leaves [first, last), and its descendants.
  template <class AddPoint>
  DipoleSum build(std::uint32_t at, std::uint32_t first, std::uint32_t last, AddPoint& add_point) {
    DipoleSum sum;
    if (last - first == 1) {
      const std::uint32_t end = std::min(points_, last * LeafPoints);
      for (std::uint32_t i = first * LeafPoints; i < end; ++i) add_point(i, sum);
    } else {
      const std::uint32_t middle = first + (last - first) / 2;
      sum = build(at + 1, first, middle, add_point);
      sum.add(build(at + 2 * (middle - first), middle, last, add_point));
    }
    DipoleNode& node = nodes_[at];
    node.skip = at + 2 * (last - first) - 1;
    node.dipole = sum.dipole;
    node.centre = Vec3f::Zero();
    node.reach2 = -1;
    if (!sum.box.empty()) {
      node.centre = sum.area > 0 ? Vec3f(sum.weighted / sum.area) : sum.box.centre();
      // The farthest corner of the box bounds the farthest point.
      const Vec3f far = (sum.box.high - node.centre).cwiseMax(node.centre - sum.box.low);
      node.reach2 = kOpening * kOpening * far.dot(far);
    }
    return sum;
  }

  std::uint32_t points_ = 0;
  std::span<DipoleNode> nodes_;
};

}  // namespace plumbline::inline slicer
