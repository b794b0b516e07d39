#pragma once
/// Gathers the points near a ray, with one search in the 2D tree for a tile of rays.

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/implicit/mls.hpp"

namespace plumbline {

/// Gathers the points around a tile of rays once, sorts them by depth and picks those of each ray. One object a thread; its
/// memory is taken once.
class RayGatherer {
 public:
  /// Bytes of arena for tiles of up to `capacity` points.
  static std::size_t bytes_needed(std::uint32_t capacity);

  /// @param capacity    points a tile; if it has more, every n-th is used
  /// @param max_radius  mm; larger support radii are cut to this, which bounds the search
  [[nodiscard]] static Expected<RayGatherer> create(const Cloud& cloud, const KdTree2& tree, std::uint32_t capacity,
                                                    float max_radius, Arena& arena);

  /// Gathers for rays in the rectangle [low, high], mm.
  void gather(const Vec2f& low, const Vec2f& high);
  std::uint32_t tile_points() const { return count_; }
  bool thinned() const { return thinned_; }  ///< the last gather() found more points than `capacity`

  struct TilePoint {
    Vec3f position;
    float radius;  ///< of its support, mm
    float slope;   ///< z of its normal
  };
  /// Depths ascend with t.
  TilePoint tile_point(std::uint32_t t) const { return {{x_[t], y_[t], tile_.depth[t]}, radius_[t], tile_.slope[t]}; }

  /// The points of the ray at (x, y), which must be in the tile. Valid until the next call.
  const RayPoints& points_of_ray(float x, float y);
  /// Squared distance in the plane of the nearest of them, mm^2; infinite if there are none.
  float nearest2() const { return nearest2_; }
  /// All points of the tile that may have weight at a depth, mm, and others that have none on the ray.
  RayPoints points_near(float x, float y, float depth);
  /// Half the length of ray, mm, on which point j of the last points_of_ray() has weight.
  float half_chord(std::uint32_t j) const { return half_chord_[j]; }

 private:
  const Cloud* cloud_ = nullptr;
  const KdTree2* tree_ = nullptr;
  float max_radius_ = 0;
  // Of the tile's points, with room for kLanes more than the capacity. What depends on the ray is set for one after another.
  RayPoints tile_;
  std::span<float> x_;
  std::span<float> y_;
  std::span<float> radius_;
  std::span<std::uint64_t> chosen_;  ///< tile points of a ray; while gathering, keys that sort them by depth
  std::span<float> half_chord_;
  RayPoints columns_;
  std::uint32_t count_ = 0;
  float nearest2_ = 0;    ///< see nearest2()
  float tile_reach_ = 0;  ///< largest radius of the tile's points, mm
  bool thinned_ = false;
};

}  // namespace plumbline
