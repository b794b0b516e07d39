#pragma once
/// Which points a ray meets: one search in the 2D tree for a tile of rays (DESIGN 3, stage 6).

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/implicit/mls.hpp"

namespace plumbline {

/// Gathers the points round a tile of rays once, sorts them by depth, and hands each ray of the tile its own. One object
/// a thread; its memory is taken once.
class RayGatherer {
 public:
  /// Bytes of arena that a gatherer for tiles of up to `capacity` points takes.
  static std::size_t bytes_needed(std::uint32_t capacity);

  /// @param capacity    points a tile: of more, an even share in depth is used
  /// @param max_radius  mm; supports are cut to this, so that a search reaches no farther
  [[nodiscard]] static Expected<RayGatherer> create(const Cloud& cloud, const KdTree2& tree, std::uint32_t capacity,
                                                    float max_radius, Arena& arena);

  /// Gathers for rays in the rectangle [low, high], mm.
  void gather(const Vec2f& low, const Vec2f& high);
  std::uint32_t tile_points() const { return count_; }
  bool thinned() const { return thinned_; }  ///< the last gather() met more points than it has room for

  /// Depth of tile point t, t ascending, and the radius within which it is seen, mm.
  float tile_depth(std::uint32_t t) const { return tile_[t].position[2]; }
  float tile_radius(std::uint32_t t) const { return tile_[t].radius; }

  /// The columns for the ray at (x, y) of the tile; valid until the next call.
  const RayPoints& points_of_ray(float x, float y);
  /// Half the depth over which point j of the last points_of_ray() has weight on the ray, mm.
  float half_chord(std::uint32_t j) const { return half_chord_[j]; }
  /// Point j of the last points_of_ray() is of a practical cluster: entering or exiting.
  bool practical(std::uint32_t j) const { return practical_[j] != 0; }
  /// Whether a place on the ray of the last points_of_ray() is in reach of walls that were continued (Cloud::continued).
  bool continued(float depth) const { return depth > continued_low_ && depth < continued_high_; }

 private:
  struct TilePoint {
    Vec3f position;
    float radius;
    Vec3f normal;
    std::uint32_t index;
    bool practical;
  };

  const Cloud* cloud_ = nullptr;
  const KdTree2* tree_ = nullptr;
  float max_radius_ = 0;
  std::span<TilePoint> tile_;
  std::span<std::uint8_t> practical_;
  std::span<float> half_chord_;
  RayPoints columns_;
  std::uint32_t count_ = 0;
  bool thinned_ = false;
  float continued_low_ = 0;  ///< mm
  float continued_high_ = 0;
};

}  // namespace plumbline
