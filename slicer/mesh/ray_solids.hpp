#pragma once
/// The stretches of one ray between its hits.

#include <algorithm>
#include <cstdint>
#include <span>

#include "slicer/mesh/hit_list.hpp"

namespace plumbline {

/// Crossings of a ray: at most as many as the store counts in a byte, and an even number.
inline constexpr std::uint32_t kMostRayCrossings = 254;

/// A stretch of a ray between two heights where hits change its winding number.
struct RayStretch {
  std::uint32_t begin = 0, end = 0;  ///< layers, half-open; begin < end
  int from_below = 0;                ///< winding number by the hits below
  int from_above = 0;                ///< by those above; equal if the ray is whole
  bool is_sure() const { return (from_below != 0) == (from_above != 0); }
  /// If it is sure. Of a mesh with faces that are turned over also if not: from_below and from_above differ by an even number then, so
  /// if one is 0, the ray passes an even number of faces below.
  bool is_solid() const { return from_below != 0 && from_above != 0; }
};

inline int winding_sum(std::span<const PackedHit> ray) {
  int sum = 0;
  for (const PackedHit& hit : ray) sum += hit.winding();
  return sum;
}

/// Calls visit(RayStretch) from the plate upwards, for all layers.
/// @param ray  its hits, in order
template <class Visit>
void for_each_stretch(std::span<const PackedHit> ray, std::uint32_t layers, Visit visit) {
  const int total = winding_sum(ray);
  RayStretch stretch;
  stretch.from_above = -total;
  std::size_t i = 0;
  while (stretch.begin < layers) {
    while (i < ray.size() && ray[i].layer() <= stretch.begin) stretch.from_below += ray[i++].winding();
    stretch.from_above = stretch.from_below - total;
    stretch.end = i < ray.size() ? std::min(ray[i].layer(), layers) : layers;
    visit(stretch);
    stretch.begin = stretch.end;
  }
}

/// Collects the layers at which a ray becomes solid or empty.
class RayToggles {
 public:
  explicit RayToggles(std::span<std::uint16_t> room) : room_(room.first(kMostRayCrossings)) {}

  /// From `layer` upwards the ray is solid or not.
  void set(std::uint32_t layer, bool solid) {
    if (solid == solid_) return;
    if (count_ == room_.size()) {
      crowded_ = true;
      return;
    }
    solid_ = solid;
    room_[count_++] = static_cast<std::uint16_t>(layer);
  }
  std::uint32_t count() const { return static_cast<std::uint32_t>(count_); }
  bool crowded() const { return crowded_; }

 private:
  std::span<std::uint16_t> room_;
  std::size_t count_ = 0;
  bool solid_ = false;
  bool crowded_ = false;
};

}  // namespace plumbline
