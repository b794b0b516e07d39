#include "firmware/pictures/preview/preview_smoothing.hpp"

#include <algorithm>
#include <array>
#include <cassert>

#include "slicer/core/numbers/lanes.hpp"

namespace plumbline::firmware::inline pictures {
namespace {

/// Slope up to which two samples belong to one surface: 81 degrees. Steeper steps are edges and stay sharp.
constexpr float kSteepest = 6.0F;
constexpr std::ptrdiff_t kMostReach = 40;

/// The samples on a line that are averaged.
struct Reach {
  explicit Reach(const VoxelSize& size) : voxel(size) {
    const float least = std::min(4.0F, 4.0F * voxel.across);
    most = static_cast<std::ptrdiff_t>(std::clamp(2.2F * voxel.across, least, float{kMostReach}));
    // Within a voxel of many samples all are alike: a few pairs will do.
    stride = std::max<std::ptrdiff_t>(most / 6, 1);
  }

  VoxelSize voxel;
  std::ptrdiff_t most;    ///< samples to each side
  std::ptrdiff_t stride;  ///< from one that counts to the next
};

/// Loads kLanes samples, or `count` into the first ones of `part`.
template <bool All>
PLUMBLINE_INLINE void load_lanes(Lanes& lanes, const float* from, std::size_t count, std::array<float, kLanes>& part) {
  if (All) return load(lanes, from);
  std::copy_n(from, count, part.begin());
  load(lanes, part.data());
}

/// Smooths `count` samples that lie side by side, each on its own line; at most kLanes.
/// @param step  from a sample of a line to the next one
/// @param most  samples that each line has on both sides, at least
template <bool All>
PLUMBLINE_INLINE void smooth_lanes(const float* from, float* to, std::size_t count, std::ptrdiff_t step,
                                   std::ptrdiff_t most, const Reach& reach) {
  std::array<float, kLanes> part;
  part.fill(DepthMap::kEmpty);
  Lanes depth, smooth;
  load_lanes<All>(depth, from, count, part);
  const Lanes none = Lanes{} + 0.0F;
  const IntLanes shown = depth < none + DepthMap::kEmpty;
  if (!any(shown)) {
    std::fill_n(to, count, DepthMap::kEmpty);
    return;
  }
  const float middle = static_cast<float>(reach.most + 1);
  Lanes weight = none + middle, sum = depth * middle;
  IntLanes counts = shown;
  // Average opposite neighbours in pairs, which leaves slopes unchanged. A pair that bends more than the steps do ends the average:
  // that bend belongs to the object.
  for (std::ptrdiff_t k = reach.stride; k <= std::min(reach.most, most); k += reach.stride) {
    Lanes a, b, rise, bend;
    load_lanes<All>(a, from - k * step, count, part);
    load_lanes<All>(b, from + k * step, count, part);
    const Lanes both = a + b, across = a - b, along = both - 2.0F * depth;
    choose(rise, across < none, -across, across);
    choose(bend, along < none, -along, along);
    const float way = static_cast<float>(k);
    bend -= 2.0F * reach.voxel.deep;
    counts =
        counts & (bend * way <= rise * reach.voxel.across) & (rise <= none + kSteepest * (way + reach.voxel.across));
    const float w = static_cast<float>(reach.most + 1 - k);
    Lanes counted;
    choose(counted, counts, w * both, none);
    sum += counted;
    choose(counted, counts, none + 2.0F * w, none);
    weight += counted;
  }
  choose(smooth, shown, sum / weight, depth);
  if (All) return store(to, smooth);
  store(part.data(), smooth);
  std::copy_n(part.begin(), count, to);
}

/// Smooths any number of samples that lie side by side.
PLUMBLINE_WIDE void smooth_samples(const float* from, float* to, std::size_t count, std::ptrdiff_t step,
                                   std::ptrdiff_t most, const Reach& reach) {
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) smooth_lanes<true>(from + i, to + i, kLanes, step, most, reach);
  if (i < count) smooth_lanes<false>(from + i, to + i, count - i, step, most, reach);
}

/// Smooths once, along rows.
void smooth_rows(const DepthMap& from, std::span<float> to, const Reach& reach) {
  const auto columns = static_cast<std::ptrdiff_t>(from.columns), rows = static_cast<std::ptrdiff_t>(from.rows);
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t row = 0; row < rows; ++row) {
    // With empty samples at both ends, which end an average as an edge of the object does.
    std::array<float, kMostSamples + 2 * kMostReach> line;
    const auto begin = line.begin() + kMostReach;
    std::fill(line.begin(), begin, DepthMap::kEmpty);
    std::fill_n(std::copy_n(from.depth.begin() + row * columns, columns, begin), kMostReach, DepthMap::kEmpty);
    smooth_samples(&*begin, &to[static_cast<std::size_t>(row * columns)], from.columns, 1, reach.most, reach);
  }
}

/// Smooths once, along columns.
void smooth_columns(const DepthMap& from, std::span<float> to, const Reach& reach) {
  const auto columns = static_cast<std::ptrdiff_t>(from.columns), rows = static_cast<std::ptrdiff_t>(from.rows);
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t row = 0; row < rows; ++row) {
    const auto begin = static_cast<std::size_t>(row * columns);
    smooth_samples(&from.depth[begin], &to[begin], from.columns, columns, std::min(row, rows - 1 - row), reach);
  }
}

}  // namespace

void smooth_depth(const DepthMap& map, std::span<float> scratch, const VoxelSize& voxel) {
  assert(map.columns <= kMostSamples);
  const Reach reach(voxel);
  const DepthMap other{scratch.first(map.depth.size()), map.material, map.columns, map.rows};
  for (int pass = 0; pass < 2; ++pass) {
    smooth_rows(map, other.depth, reach);
    smooth_columns(other, map.depth, reach);
  }
}

}  // namespace plumbline::firmware::inline pictures
