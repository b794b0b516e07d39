#include "slicer/placement/base_plane.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <iterator>

namespace plumbline::inline slicer {
namespace {

/// Number of the lowest points that may be outliers. A larger number would cut off the tip of a sparse scan; with a
/// smaller one, outliers move the plane.
constexpr std::size_t kOutliers = 12;

constexpr std::size_t kBinsALayer = 5;  ///< resolution of the plane's height: errors far below a layer don't show
constexpr std::size_t kBins = 24 * kBinsALayer;       ///< of the histogram, from a layer below the lowest point
constexpr std::size_t kWallsFrom = 12 * kBinsALayer;  ///< first bin of the walls: above any rise that noise has blurred
/// Bins in which the density rises from a tenth to half of the walls': a rim blurred by noise takes fewer, a tip more.
constexpr std::size_t kSharpRise = 2 * kBinsALayer;
constexpr std::uint64_t kFewest = 200;  ///< points in the walls' bins; with fewer, a rise may be chance

/// Height of the lowest point after the kOutliers lowest.
float lowest_without_outliers(std::span<const Vec3f> points) {
  std::array<Vec3f, kOutliers + 1> lowest;
  const auto lower = [](const Vec3f& a, const Vec3f& b) { return a[2] < b[2]; };
  const auto end = std::partial_sort_copy(points.begin(), points.end(), lowest.begin(), lowest.end(), lower);
  return (*std::prev(end))[2];
}

}  // namespace

float base_plane(std::span<const Vec3f> points, float resolution) {
  assert(!points.empty() && resolution > 0);
  const float lowest = lowest_without_outliers(points);
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

  // Compares the density of each layer, a window of kBinsALayer bins, with that of the walls.
  const auto reaches_share = [&](std::uint64_t divisor, std::uint64_t sum) {
    return sum * (kBins - kWallsFrom) * divisor >= walls * kBinsALayer;
  };
  std::size_t tenth = kBins;
  std::uint64_t sum = 0;
  for (std::size_t end = 0; end < kWallsFrom; ++end) {
    sum += counts[end];
    if (end >= kBinsALayer) sum -= counts[end - kBinsALayer];
    if (tenth == kBins && reaches_share(10, sum)) tenth = end;
    if (!reaches_share(2, sum)) continue;
    if (end - tenth > kSharpRise) break;
    // The middle of the window.
    return std::max(lowest, start + (static_cast<float>(end) + 1 - 0.5F * kBinsALayer) * bin);
  }
  return lowest;
}

}  // namespace plumbline::inline slicer
