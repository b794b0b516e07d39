#include "slicer/extrapolated.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace plumbline {
namespace {

constexpr float kHalf = 0.5F;  ///< the surface, to the winding number
constexpr int kBisections = 4;

/// One side of a crossing: the stretch to the next one, which is solid or empty all along.
struct Side {
  float x, y;    ///< mm
  float depth;   ///< mm, of the crossing
  float length;  ///< mm, below 0: downwards
  bool solid;

  bool agrees(const WindingTree& winding, float share) const {
    return (winding({x, y, depth + share * length}) > kHalf) == solid;
  }
};

/// Where, from the crossing on, the winding number comes to agree with the stretch; a share of its length.
std::optional<float> first_agreed(const Side& side, const WindingTree& winding, float step) {
  for (float share = 2 * step; share < 1; share += step) {
    if (!side.agrees(winding, share)) continue;
    float low = share - step;
    float high = share;
    for (int k = 0; k < kBisections; ++k) {
      const float middle = 0.5F * (low + high);
      (side.agrees(winding, middle) ? high : low) = middle;
    }
    return 0.5F * (low + high);
  }
  return {};
}

}  // namespace

bool settle_extrapolated(std::span<RayCrossing>& crossings, float x, float y, const WindingTree& winding, float step) {
  bool changed = false;
  for (std::size_t i = 0; i < crossings.size();) {
    const std::size_t at = i++;
    RayCrossing& c = crossings[at];
    if (!c.extrapolated) continue;
    for (const bool up : {true, false}) {
      // Beyond the outermost sheets there is nothing to end what would begin there.
      if (up ? i == crossings.size() : at == 0) continue;
      const std::size_t lower = up ? at : at - 1;
      const float length = crossings[up ? i : lower].depth - c.depth;
      const Side side{x, y, c.depth, length, lower % 2 == 0};
      const float share = std::min(0.5F, step / std::abs(length));
      if (length == 0 || side.agrees(winding, share)) continue;
      changed = true;
      if (const auto agreed = first_agreed(side, winding, share)) {
        c.depth += *agreed * length;
        c.evidence = Evidence::kWinding;
      } else {
        std::copy(crossings.begin() + lower + 2, crossings.end(), crossings.begin() + lower);
        crossings = crossings.first(crossings.size() - 2);
        i = lower;
      }
      break;
    }
  }
  return changed;
}

}  // namespace plumbline
