#pragma once
/// Where one scan of several lies in their common frame.

#include <cmath>

#include "slicer/core/vec.hpp"
#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline {

struct ScanPose {
  Mat3d rotation = Mat3d::Identity();
  Vec3d translation = Vec3d::Zero();

  /// p' = rotation * p + translation. Normals are rotated.
  void apply(SlotValues& row) const {
    const Vec3d p = rotation * Vec3d(row[kX], row[kY], row[kZ]) + translation;
    const Vec3d n = rotation * Vec3d(row[kNx], row[kNy], row[kNz]);
    for (int a = 0; a < 3; ++a) {
      row[kX + a] = p[a];
      row[kNx + a] = n[a];
    }
  }
};

}  // namespace plumbline
