#pragma once
/// Winding number of part of a cloud, and its gradient, for the stage that orients normals.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/implicit/dipole_tree.hpp"

namespace plumbline::inline slicer {

/// Like WindingTree, but with larger leaves: it is evaluated rarely and must be small.
class DipoleField {
 public:
  using Tree = DipoleTree<32>;
  using Node = DipoleNode;
  struct Value {
    float winding = 0;
    Vec3f gradient = Vec3f::Zero();  ///< 1/mm
  };
  using Sign = FunctionRef<float(std::uint32_t)>;

  static std::size_t nodes_needed(std::uint32_t points) { return Tree::nodes_needed(points); }

  /// @param cloud  in the order of its 3D tree; radius[i]^2 pi is the area of point i
  /// @param nodes  nodes_needed(cloud.size) of them
  DipoleField(const Cloud& cloud, std::span<Node> nodes) : cloud_(cloud), tree_(cloud.size, nodes) {}

  /// @param sign  factor for the normal of point i: 1 or -1; 0 leaves the point out
  void build(Sign sign);

  /// The field at x, mm. Thread-safe.
  /// @param sign  as for build()
  /// @param share  of DipoleTree::walk
  Value operator()(const Vec3f& x, Sign sign, float share = 1) const;

 private:
  const Cloud& cloud_;
  Tree tree_;
};

}  // namespace plumbline::inline slicer
