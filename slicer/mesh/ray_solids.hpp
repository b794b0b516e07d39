#pragma once
/// The stretches of one ray between its hits.

#include <algorithm>
#include <cstdint>
#include <span>

#include "slicer/mesh/hit_list.hpp"

namespace plumbline::inline slicer {

/// Crossings of a ray: at most as many as the store counts in a byte, and an even number.
inline constexpr std::uint32_t kMostRayCrossings = 254;

/// A stretch of a ray between two heights where hits change its winding number.
struct RayStretch {
  std::uint32_t begin = 0, end = 0;  ///< layers, half-open; begin < end
  int from_below = 0;                ///< winding number by the hits below
  int from_above = 0;                ///< by those above; equal if the ray is whole
  int from_all_above = 0;            ///< by those above, with those that are left out because they are there twice
  bool is_sure() const { return (from_below != 0) == (from_above != 0); }
  /// If it is sure.
  bool is_solid() const { return from_below != 0 && from_above != 0; }
};

inline int winding_sum(const RayHits& ray) {
  int sum = 0;
  for (std::size_t i = 0; i < ray.size(); ++i) sum += ray.keeps(i) ? ray.winding(i) : 0;
  return sum;
}
inline int winding_sum_of_all(const RayHits& ray) { return winding_sum({ray.all, ray.packing}); }

/// Calls visit(RayStretch) from the plate upwards, for all layers.
template <class Visit>
void for_each_stretch(const RayHits& ray, std::uint32_t layers, Visit visit) {
  RayStretch stretch;
  stretch.from_above = -winding_sum(ray);
  stretch.from_all_above = -winding_sum_of_all(ray);
  std::size_t i = 0;
  while (stretch.begin < layers) {
    for (; i < ray.size() && ray.layer(i) <= stretch.begin; ++i) {
      const int winding = ray.winding(i);
      stretch.from_all_above += winding;
      if (!ray.keeps(i)) continue;
      stretch.from_below += winding;
      stretch.from_above += winding;
    }
    stretch.end = i < ray.size() ? std::min(ray.layer(i), layers) : layers;
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

}  // namespace plumbline::inline slicer
