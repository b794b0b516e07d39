#pragma once
/// Surfaces as clouds, at each stage of the slicer.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/rays/ray_points.hpp"
#include "slicer/surface/clustering.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline::testing {

/// The value; on error, ends the test with the error's message.
template <class T>
T value_of(Expected<T> expected) {
  if (!expected) throw std::runtime_error(expected.error().message());
  return *std::move(expected);
}
inline void check(const Status& status) {
  if (!status) throw std::runtime_error(status.error().message());
}

/// @param radius  of every point
/// @param views   of each point, which its scanner's place is not known of; empty: none
inline Cloud cloud_of(const Surface& surface, Arena& arena, float radius = 0,
                      std::span<const std::uint8_t> views = {}) {
  Cloud cloud = value_of(Cloud::create(static_cast<std::uint32_t>(surface.size()), arena, !views.empty()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    cloud.views.of[i] = views[i];
    if (views[i] != kNoView) cloud.views.count = std::max(cloud.views.count, views[i] + 1U);
  }
  std::ranges::fill(cloud.views.has_scanner, false);
  for (const SurfacePoint& p : surface) {
    cloud.position[cloud.size] = p.position.cast<float>();
    cloud.normal[cloud.size] = PackedNormal{};
    cloud.normal[cloud.size].set(p.normal.cast<float>());
    cloud.radius[cloud.size] = radius;
    ++cloud.size;
  }
  return cloud;
}

/// Builds the 3D tree, which stays in the arena, and puts the cloud in its order.
inline KdTree3 sort_by_tree(Cloud& cloud, Arena& arena) {
  KdTree3 tree = value_of(KdTree3::build(cloud.positions(), arena, "test"));
  cloud.reorder(tree.order());
  return tree;
}

/// A cloud as it is when rays are shot: clustered, with its 2D tree.
struct ClusteredScan {
  Cloud cloud;
  ClusteringResult clustering;
  KdTree2 tree;

  /// Supports are cut to what slice() finds usual. None is listed as wide.
  SupportWidths widths() const { return {usual_support(clustering.epsilon, cloud.support_points)}; }
};
inline ClusteredScan clustered(const Surface& surface, Arena& arena, SparseSurface sparse = SparseSurface::kKept) {
  Cloud cloud = cloud_of(surface, arena);
  ClusteringResult result;
  {
    const ArenaScope scope(arena);
    const KdTree3 tree = sort_by_tree(cloud, arena);
    const float epsilon = value_of(density_epsilon(cloud, tree, arena));
    result = value_of(cluster(cloud, tree, epsilon, arena, {}, sparse));
  }
  return {cloud, result, value_of(KdTree2::build(cloud.positions(), arena, "test"))};
}

/// The scan as a file: PLY, binary little endian, position and normal as floats.
inline std::string binary_ply(const Surface& surface) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(surface.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
                      "property float nz\nend_header\n";
  for (const SurfacePoint& p : surface) {
    for (const Vec3d& v : {p.position, p.normal}) {
      const Vec3f f = v.cast<float>();
      bytes.append(reinterpret_cast<const char*>(f.data()), 3 * sizeof(float));
    }
  }
  return bytes;
}

}  // namespace plumbline::testing
