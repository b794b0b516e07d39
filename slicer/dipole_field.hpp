#pragma once
/// Winding number of part of a cloud and its gradient, while its normals are still being turned.

#include <cstdint>
#include <span>

#include "slicer/cloud.hpp"
#include "slicer/kd_tree.hpp"

namespace plumbline {

/// As WindingTree (Barill et al. 2018, first order), but over larger leaves: it answers few questions and has to be small.
class DipoleField {
 public:
  static constexpr std::uint32_t kLeafPoints = 32;

  struct Node {
    Vec3f centre;            ///< mean position weighted by area, mm
    float reach2 = 0;        ///< (opening * radius)^2, mm^2; farther away the node is one dipole
    Vec3f dipole;            ///< sum of a_i s_i n_i / (4 pi), mm^2
    std::uint32_t skip = 0;  ///< next node when this one is not opened
  };
  struct Value {
    float winding = 0;
    Vec3f gradient = Vec3f::Zero();  ///< 1/mm
  };
  using Sign = FunctionRef<float(std::uint32_t)>;

  static std::size_t nodes_needed(std::uint32_t points);

  /// @param cloud  in the order of its 3D tree; radius[i]^2 pi is the area of point i
  /// @param nodes  nodes_needed(cloud.size) of them
  DipoleField(const Cloud& cloud, std::span<Node> nodes) : cloud_(cloud), nodes_(nodes) {}

  /// @param sign  of the normal of point i: 1 or -1, 0 for points that are no part of the field
  void build(Sign sign);

  /// The field at x. `sign` as it was for build(); may be called by many threads.
  Value operator()(const Vec3f& x, Sign sign) const;

 private:
  struct Sum;
  Sum build(std::uint32_t at, std::uint32_t first, std::uint32_t last, Sign sign);

  const Cloud& cloud_;
  std::span<Node> nodes_;
};

}  // namespace plumbline
