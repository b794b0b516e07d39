#include "slicer/placement/base_plane.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>

namespace plumbline {
namespace {

/// As many of the lowest points may be strays.
constexpr std::size_t kStrays = 12;

constexpr std::size_t kBinsALayer = 5;
constexpr std::size_t kBins = 24 * kBinsALayer;       ///< from a layer below the lowest point but the strays
constexpr std::size_t kWallsFrom = 12 * kBinsALayer;  ///< above the rise, whatever its noise and the strays below it
/// From a tenth to the half of the full density: a rim that noise has blurred rises within this many bins, a tip takes longer.
constexpr std::size_t kSharpRise = 2 * kBinsALayer;
constexpr std::uint64_t kFewest = 200;  ///< points of the walls, to tell a rise from chance

float lowest_but_strays(std::span<const Vec3f> points) {
  std::array<float, kStrays + 1> lowest{};  // a heap, the highest first
  std::size_t count = 0;
  for (const Vec3f& p : points) {
    if (count == lowest.size() && p[2] >= lowest[0]) continue;
    if (count == lowest.size()) std::pop_heap(lowest.begin(), lowest.begin() + count--);
    lowest[count++] = p[2];
    std::push_heap(lowest.begin(), lowest.begin() + count);
  }
  return lowest[0];
}

}  // namespace

float base_plane(std::span<const Vec3f> points, float resolution) {
  assert(!points.empty() && resolution > 0);
  const float lowest = lowest_but_strays(points);
  const float bin = resolution / kBinsALayer;
  const float start = lowest - resolution;
  std::array<std::uint32_t, kBins> counts{};
  for (const Vec3f& p : points) {
    const float at = (p[2] - start) / bin;
    if (at >= 0 && at < static_cast<float>(kBins)) ++counts[static_cast<std::size_t>(at)];
  }
  std::uint64_t walls = 0;
  for (std::size_t i = kWallsFrom; i < kBins; ++i) walls += counts[i];
  if (walls < kFewest) return lowest;

  // A layer's sum at a time, compared with that of the walls.
  constexpr std::uint64_t kWallBins = kBins - kWallsFrom;
  const auto reached = [&](std::uint64_t share_in, std::uint64_t sum) {
    return sum * kWallBins * share_in >= walls * kBinsALayer;
  };
  std::size_t tenth = kBins;
  std::uint64_t sum = 0;
  for (std::size_t end = 0; end < kWallsFrom; ++end) {
    sum += counts[end];
    if (end >= kBinsALayer) sum -= counts[end - kBinsALayer];
    if (tenth == kBins && reached(10, sum)) tenth = end;
    if (!reached(2, sum)) continue;
    if (end - tenth > kSharpRise) break;
    // The middle of the bins that were summed.
    return std::max(lowest, start + (static_cast<float>(end) + 1 - 0.5F * kBinsALayer) * bin);
  }
  return lowest;
}

}  // namespace plumbline
