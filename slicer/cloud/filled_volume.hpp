#pragma once
/// Tells points that fill a volume, as those of a tomograph, from those of a surface.

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"

namespace plumbline::inline slicer {

/// What a sample of the points has around it, in balls of 2 r and 4 r where r is the distance of the 16th neighbour.
struct PointSpread {
  double roundness =
      0;  ///< least variance over the largest of the points in the larger ball; upper quartile. A sheet has 0, a ball 1
  double inner_roundness =
      0;              ///< the same of the smaller ball. Storeys, sheets beside each other at some distance, have 0
  double growth = 0;  ///< points in the larger ball over those in the smaller one; median. A sheet has 4, a volume 8

  /// Whether points in which no surface was found fill a volume. Balls and lattices of 3,000 points and more have 0.54 and more, at a growth of
  /// 4.8 to 8; scans 0.03 to 0.13 at 4 to 4.4; a sphere whose noise is 3 spacings 0.3 at 5.2. Noisy sheets 7 to 10 spacings apart look alike
  /// (0.59 at 5.9), so a surface that was found counts more.
  bool fills_volume() const { return inner_roundness > 0.3 && roundness > 0.5 && growth > 4.9; }
};

/// @param cloud  in the order of `tree`
PointSpread point_spread(const Cloud& cloud, const KdTree3& tree);

}  // namespace plumbline::inline slicer
