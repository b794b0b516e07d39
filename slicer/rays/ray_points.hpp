#pragma once
/// Gathers the points near a ray, with one search in the 2D tree for a tile of rays.

#include <algorithm>
#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/implicit/mls.hpp"

namespace plumbline::inline slicer {

/// How wide supports are on rays. A few may be far wider than the others, where the scan is sparse: a search as wide as these would
/// meet too many points everywhere.
struct SupportWidths {
  float usual = 0;   ///< mm; wider ones are cut to this, or, if they are listed, to `share` of their radius
  float share = 0;   ///< 0 to 1
  float least = 0;   ///< mm; narrower ones are widened to this
  float widest = 0;  ///< mm, of those that are listed
  std::span<const std::uint32_t> wide = {};  ///< all points of which that share is wider than usual, by x

  bool is_wide(float radius) const { return share * radius > usual; }
  /// Of the support of a point with that radius, mm.
  float of(float radius) const { return std::max(least, std::min(radius, std::max(usual, share * radius))); }
};

/// Gathers the points around a tile of rays once, sorts them by depth and picks those of each ray. One object a thread; its
/// memory is taken once.
class RayGatherer {
 public:
  /// Bytes of arena for tiles of up to `capacity` points.
  static std::size_t bytes_needed(std::uint32_t capacity);

  /// @param capacity  points a tile; if it has more, every n-th is used
  [[nodiscard]] static Expected<RayGatherer> create(const Cloud& cloud, const KdTree2& tree, std::uint32_t capacity,
                                                    const SupportWidths& widths, Arena& arena);

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
  /// All points of the tile that may have weight at a depth, mm, and others that have none on the ray.
  RayPoints points_near(float x, float y, float depth);
  /// Half the length of ray, mm, on which point j of the last points_of_ray() has weight.
  float half_chord(std::uint32_t j) const { return half_chord_[j]; }

 private:
  const Cloud* cloud_ = nullptr;
  const KdTree2* tree_ = nullptr;
  SupportWidths widths_;
  // Of the tile's points, with room for kLanes more than the capacity. What depends on the ray is set for one after another.
  RayPoints tile_;
  std::span<float> x_;
  std::span<float> y_;
  std::span<float> radius_;
  std::span<std::uint64_t> chosen_;  ///< tile points of a ray; while gathering, keys that sort them by depth
  std::span<float> half_chord_;
  RayPoints columns_;
  std::uint32_t count_ = 0;
  float tile_reach_ = 0;  ///< largest radius of the tile's points, mm
  bool thinned_ = false;
};

}  // namespace plumbline::inline slicer
