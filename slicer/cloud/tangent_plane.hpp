#pragma once
/// Tangent planes by principal components.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"

namespace plumbline {

/// Looks at one point after another; those of a run lie near each other, and what sufficed for one is what the next will
/// need. The planes do not depend on it.
class TangentPlanes {
 public:
  TangentPlanes(const Cloud& cloud, const KdTree3& tree) : cloud_(cloud), tree_(tree) {}

  /// Finds the nearest points of point i.
  void look_at(std::uint32_t i);

  /// Radius of a disc as large as the share of the surface of the point looked at, mm.
  float share_radius() const;

  /// The plane of the nearest points (Hoppe et al., Surface Reconstruction from Unorganized Points, 1992, section 3.2): 20 of
  /// them, more where their residual from the plane is large for their reach.
  /// @returns its normal, on either side; none where they lie on a line or in one place
  std::optional<Vec3f> normal();

  /// Those that the plane was fitted to, nearest first, the point itself included.
  std::span<const Neighbour> points() const { return std::span(found_).first(used_); }

 private:
  static constexpr std::array<std::uint32_t, 3> kPoints = {20, 40, 80};

  std::uint32_t search(std::size_t size);

  const Cloud& cloud_;
  const KdTree3& tree_;
  std::uint32_t at_ = 0;
  std::uint32_t have_ = 0;                       ///< nearest points found so far
  std::uint32_t used_ = 0;                       ///< of the plane
  std::size_t expected_ = 0;                     ///< saves searches, changes no result
  std::array<Neighbour, kPoints.back()> found_;  // NOLINT(cppcoreguidelines-pro-type-member-init)
};

}  // namespace plumbline
