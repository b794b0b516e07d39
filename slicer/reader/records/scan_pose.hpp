#pragma once
/// Where one scan of several lies in their common frame.

#include <cmath>
#include <optional>

#include "slicer/core/numbers/vec.hpp"
#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline::inline slicer {

/// The rotation of a quaternion of any length but 0.
/// @returns nothing if its length is 0 or not finite
inline std::optional<Mat3d> rotation_of(double w, double x, double y, double z) {
  const double n = w * w + x * x + y * y + z * z;
  if (!(n > 0) || !std::isfinite(n)) return std::nullopt;
  const double s = 2 / n;
  Mat3d rotation;
  rotation << 1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y),  //
      s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x),          //
      s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y);
  if (!rotation.allFinite()) return std::nullopt;
  return rotation;
}

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

}  // namespace plumbline::inline slicer
