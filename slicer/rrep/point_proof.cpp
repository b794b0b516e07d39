#include "slicer/rrep/point_proof.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace plumbline::inline slicer {
namespace {

struct Direction {
  float x, y;
};
constexpr float kHalfRoot = 0.70710678F;
constexpr std::array<Direction, 8> kAround = {{{1, 0},
                                               {kHalfRoot, kHalfRoot},
                                               {0, 1},
                                               {-kHalfRoot, kHalfRoot},
                                               {-1, 0},
                                               {-kHalfRoot, -kHalfRoot},
                                               {0, -1},
                                               {kHalfRoot, -kHalfRoot}}};

/// What a ray says of a height.
struct RayLook {
  bool solid = false;
  float nearest = std::numeric_limits<float>::max();  ///< distance to the ray's nearest crossing, mm
};

class Prover {
 public:
  explicit Prover(const CrossingStore& store) : store_(store), grid_(store.grid()) {}

  /// Distance to the surface, about: never less than the true one by more than half a pixel or half a layer.
  float distance(const Vec3f& p, std::span<const float> rings) const {
    const RayLook own = look(p[0], p[1], p[2]);
    float least = own.nearest;
    for (const float ring : rings) {
      if (ring >= least) break;
      for (const Direction& to : kAround) {
        const RayLook other = look(p[0] + ring * to.x, p[1] + ring * to.y, p[2]);
        if (other.solid != own.solid) {
          least = ring;
          break;  // no other ray of the ring is nearer
        }
        least = std::min(least, std::sqrt(ring * ring + other.nearest * other.nearest));
      }
    }
    return least;
  }

 private:
  RayLook look(float x, float y, float z) const {
    const float column = std::floor(x / grid_.pitch_x_mm), row = std::floor(y / grid_.pitch_y_mm);
    if (!(column >= 0 && row >= 0 && column < static_cast<float>(grid_.columns) &&
          row < static_cast<float>(grid_.rows))) {
      return {};
    }
    RayLook found;
    const auto crossings = store_.ray(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row));
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      const float height = static_cast<float>(crossings.layer(i)) * grid_.layer_height_mm;
      if (height <= z) found.solid = !found.solid;
      found.nearest = std::min(found.nearest, std::abs(height - z));
    }
    return found;
  }

  const CrossingStore& store_;
  const PrintGrid& grid_;
};

}  // namespace

Told told_off(const PointProof& proof) {
  return {ToldCode::kPointsOff, {{Fact::kPercent, 100 * proof.share_off()}, {Fact::kLimitMm, proof.reach_mm}}};
}

PointProof prove(const CrossingStore& store, std::span<const Vec3f> points, float reach_mm) {
  const PrintGrid& grid = store.grid();
  const float pixel = std::max(grid.pitch_x_mm, grid.pitch_y_mm);
  PointProof proof;
  proof.points = static_cast<std::uint32_t>(points.size());
  proof.reach_mm = std::max({reach_mm, 2 * pixel, 2 * grid.layer_height_mm});
  const std::array<float, 3> rings = {pixel, 0.5F * proof.reach_mm, proof.reach_mm};
  const Prover prover(store);
  for (const Vec3f& p : points) {
    const float distance = prover.distance(p, rings);
    if (distance <= pixel) ++proof.within_pixel;
    if (distance <= grid.layer_height_mm) ++proof.within_layer;
    if (distance > proof.reach_mm) ++proof.off;
  }
  return proof;
}

}  // namespace plumbline::inline slicer
