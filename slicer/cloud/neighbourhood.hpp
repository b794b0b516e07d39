#pragma once
/// The points near a block of consecutive points in the order of the tree: one search serves the whole block.

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/numbers/lanes.hpp"

namespace plumbline::inline slicer {

/// Points of a block. Larger blocks save searches, but compare each point with more candidates that are out of its reach.
inline constexpr std::uint32_t kSharedSearch = 32;

/// The thesis' metric as a test (III-2.b): |d| / <n_i, n_j> <= epsilon, and the inner product is positive. It compares
/// squares, without a root or a division.
struct Within {
  float distance2;
  float cosine;
  bool near(float epsilon2) const { return cosine > 0 && distance2 <= epsilon2 * cosine * cosine; }
};

/// Candidates of one block, with one array for each coordinate. The arrays are padded to a multiple of kLanes.
struct Neighbourhood {
  static constexpr std::uint32_t kMost = 256;  ///< points: 8 KiB, which stay in the first-level cache

  alignas(64) float x[kMost];
  alignas(64) float y[kMost];
  alignas(64) float z[kMost];
  alignas(64) float nx[kMost];
  alignas(64) float ny[kMost];
  alignas(64) float nz[kMost];
  alignas(64) std::int32_t type[kMost];
  alignas(64) std::uint32_t index[kMost];
  std::uint32_t size = 0;

  /// Pads the arrays with points that have no normal.
  void pad() {
    for (std::uint32_t j = size; j % kLanes != 0; ++j) {
      x[j] = y[j] = z[j] = nx[j] = ny[j] = nz[j] = 0;
      type[j] = -1;
    }
  }
};

/// kLanes candidates.
struct NeighbourLanes {
  Lanes x, y, z, nx, ny, nz;
  IntLanes type;
};
PLUMBLINE_INLINE void load(NeighbourLanes& lanes, const Neighbourhood& from, std::uint32_t at) {
  load(lanes.x, from.x + at);
  load(lanes.y, from.y + at);
  load(lanes.z, from.z + at);
  load(lanes.nx, from.nx + at);
  load(lanes.ny, from.ny + at);
  load(lanes.nz, from.nz + at);
  load(lanes.type, from.type + at);
}

/// A point of a block, unpacked.
struct Member {
  Vec3f position;
  Vec3f normal;
  std::int32_t type;
};

inline Member member(const Cloud& cloud, std::uint32_t i) {
  return {cloud.position[i], cloud.normal[i].unpack(), static_cast<std::int32_t>(cloud.normal[i].point_class)};
}

/// Calls `use(batch)` for batches of all points within `reach` of a box.
template <class Use>
void for_neighbourhood(const Cloud& cloud, const KdTree3& tree, const Box3f& box, float reach, Use use) {
  const Vec3f margin = Vec3f::Constant(reach);
  const Vec3f low = box.low - margin;
  const Vec3f high = box.high + margin;
  Neighbourhood batch;
  tree.visit_box(low, high, [&](std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t i = from; i < to; ++i) {
      const Vec3f& p = cloud.position[i];
      const bool inside =
          p[0] >= low[0] && p[0] <= high[0] && p[1] >= low[1] && p[1] <= high[1] && p[2] >= low[2] && p[2] <= high[2];
      if (!inside) continue;
      const std::uint32_t at = batch.size;
      const Vec3f n = cloud.normal[i].unpack();
      batch.x[at] = p[0];
      batch.y[at] = p[1];
      batch.z[at] = p[2];
      batch.nx[at] = n[0];
      batch.ny[at] = n[1];
      batch.nz[at] = n[2];
      batch.type[at] = static_cast<std::int32_t>(cloud.normal[i].point_class);
      batch.index[at] = i;
      if (++batch.size == Neighbourhood::kMost) {
        use(batch);
        batch.size = 0;
      }
    }
  });
  batch.pad();
  if (batch.size > 0) use(batch);
}
/// The same for the bounding box of points [first, last).
template <class Use>
void for_neighbourhood(const Cloud& cloud, const KdTree3& tree, std::uint32_t first, std::uint32_t last, float reach,
                       Use use) {
  Box3f box;
  for (std::uint32_t i = first; i < last; ++i) box.extend(cloud.position[i]);
  for_neighbourhood(cloud, tree, box, reach, use);
}

}  // namespace plumbline::inline slicer
