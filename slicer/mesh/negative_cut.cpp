#include "slicer/mesh/negative_cut.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "slicer/reader/triangles/triangle.hpp"

namespace plumbline::inline slicer {
namespace {

/// The bodies that a ray passes.
class RayBodies {
 public:
  explicit RayBodies(const HitPacking& packing) : packing_(packing) {}
  void count(std::span<const PackedHit> hits) {
    for (const PackedHit& hit : hits) {
      if (Entry* const entry = find(hit.body())) entry->sum += packing_.winding(hit);
    }
  }
  void pass(const PackedHit& hit) {
    if (Entry* const entry = find(hit.body())) entry->winding += packing_.winding(hit);
  }
  bool is_cut() const {
    const auto used = std::span(entries_).first(count_);
    const auto is_in = [](const Entry& e, bool negative) { return e.body.is_negative() == negative && e.is_inside(); };
    if (std::ranges::none_of(used, [&](const Entry& e) { return is_in(e, true); })) return false;
    return std::ranges::all_of(used, [&](const Entry& solid) {
      return !is_in(solid, false) || std::ranges::any_of(used, [&](const Entry& e) {
        return is_in(e, true) && e.body.item() == solid.body.item();
      });
    });
  }

 private:
  struct Entry {
    BodyLabel body;
    int sum = 0;
    int winding = 0;
    bool is_inside() const { return winding != 0 && winding != sum; }
  };

  /// @returns null if there are too many on one ray
  Entry* find(std::uint32_t number) {
    const BodyLabel body = BodyLabel::of(number);
    const auto used = std::span(entries_).first(count_);
    const auto at = std::ranges::find(used, body, &Entry::body);
    if (at != used.end()) return &*at;
    if (count_ == entries_.size()) return nullptr;
    entries_[count_].body = body;
    return &entries_[count_++];
  }

  HitPacking packing_;
  std::array<Entry, 64> entries_{};
  std::size_t count_ = 0;
};

}  // namespace

void cut_negative(std::span<const std::uint16_t> solid, const RayHits& hits, std::span<const PackedHit> negative,
                  std::uint32_t layers, RayToggles& toggles) {
  const HitPacking& packing = hits.packing;
  RayBodies bodies(packing);
  bodies.count(hits.all);
  bodies.count(negative);
  auto solids = hits.all;
  bool is_solid = false;
  for (std::uint32_t layer = 0; layer < layers;) {
    for (; !solid.empty() && solid.front() <= layer; solid = solid.subspan(1)) is_solid = !is_solid;
    for (; !solids.empty() && packing.layer(solids.front()) <= layer; solids = solids.subspan(1))
      bodies.pass(solids.front());
    for (; !negative.empty() && packing.layer(negative.front()) <= layer; negative = negative.subspan(1)) {
      bodies.pass(negative.front());
    }
    toggles.set(layer, is_solid && !bodies.is_cut());
    layer = layers;
    if (!solid.empty()) layer = std::min<std::uint32_t>(layer, solid.front());
    if (!solids.empty()) layer = std::min(layer, packing.layer(solids.front()));
    if (!negative.empty()) layer = std::min(layer, packing.layer(negative.front()));
  }
}

GridClipper::Polygon GridClipper::above(const Polygon& polygon, int axis, double at, double sign) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Vec3d& from = polygon.corner[i];
    const Vec3d& to = polygon.corner[(i + 1) % polygon.count];
    const double before = sign * (from[axis] - at);
    const double after = sign * (to[axis] - at);
    if (before >= 0) kept.add(from);
    if ((before < 0) == (after < 0) || before == 0 || after == 0) continue;
    // From the same end in both triangles of an edge, so that they round alike.
    const bool forwards = std::tie(from[0], from[1], from[2]) < std::tie(to[0], to[1], to[2]);
    const Vec3d& low = forwards ? from : to;
    const Vec3d& high = forwards ? to : from;
    Vec3d middle = low + (high - low) * ((at - low[axis]) / (high[axis] - low[axis]));
    middle[axis] = at;
    kept.add(middle);
  }
  return kept;
}

LatticePoint GridClipper::rounded(const Vec3d& p) const {
  const auto round = [&](int axis) {
    return static_cast<std::int32_t>(std::clamp(std::floor(p[axis] + 0.5), 0.0, last_[axis]));
  };
  return {round(0), round(1), round(2)};
}

}  // namespace plumbline::inline slicer
