#include "slicer/rays/extrapolated.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace plumbline::inline slicer {
namespace {

/// Step of the search on either side of a crossing, as a share of the reach. Must be wider than the noise.
constexpr float kStep = 0.25F;
constexpr float kTolerance = 1.0F / 16;  ///< of the bisection, as a share of the step

/// First depth, from a crossing towards the next, where the winding number agrees with the interval between them.
/// @param solid  whether that interval is solid
std::optional<float> first_agreed(ColumnWinding& winding, float x, float y, float depth, float next, float step,
                                  bool solid) {
  const float stride = next > depth ? step : -step;
  const auto places = static_cast<int>(std::ceil(std::abs(next - depth) / step));
  for (int k = 2; k < places; ++k) {
    const float z = depth + static_cast<float>(k) * stride;
    if (winding.inside({x, y, z}) == solid)
      return winding.surface_between(x, y, z - stride, z, !solid, kTolerance * step);
  }
  return {};
}

/// Removes crossings `low` and the one above it.
void remove_pair(std::span<RayCrossing>& crossings, std::size_t low) {
  std::ranges::copy(crossings.subspan(low + 2), crossings.subspan(low).begin());
  crossings = crossings.first(crossings.size() - 2);
}

}  // namespace

bool fill_short_hollows(std::span<RayCrossing>& crossings, float x, float y, ColumnWinding& winding, float reach) {
  const std::size_t before = crossings.size();
  for (std::size_t exit = 1; exit + 1 < crossings.size();) {
    const float low = crossings[exit].depth;
    const float high = crossings[exit + 1].depth;
    if (high > low && high - low < reach && winding.inside({x, y, 0.5F * (low + high)})) {
      remove_pair(crossings, exit);
    } else {
      exit += 2;
    }
  }
  return crossings.size() < before;
}

bool settle_extrapolated(std::span<RayCrossing>& crossings, float x, float y, ColumnWinding& winding, float reach) {
  bool changed = false;
  for (std::size_t i = 0; i < crossings.size();) {
    const std::size_t at = i++;
    RayCrossing& c = crossings[at];
    if (!c.extrapolated) continue;
    for (const bool up : {true, false}) {
      // Outermost crossings don't move outwards: no crossing beyond them would end the interval.
      if (up ? i == crossings.size() : at == 0) continue;
      const std::size_t lower = up ? at : at - 1;
      const bool solid = lower % 2 == 0;
      const float next = crossings[up ? i : lower].depth;
      const float step = std::min(kStep * reach, 0.5F * std::abs(next - c.depth));
      if (step == 0 || winding.inside({x, y, up ? c.depth + step : c.depth - step}) == solid) continue;
      changed = true;
      if (const auto agreed = first_agreed(winding, x, y, c.depth, next, step, solid)) {
        c.depth = *agreed;
        c.evidence = Evidence::kWinding;
      } else {
        remove_pair(crossings, lower);
        i = lower;
      }
      break;
    }
  }
  return changed;
}

}  // namespace plumbline::inline slicer
