#include "firmware/pictures/preview/preview_shading.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>

#include "slicer/core/numbers/lanes.hpp"

namespace plumbline::firmware::inline pictures {
namespace {

/// Rise from one sample to the next above which they are of two surfaces: of 84 degrees.
constexpr float kJump = 9.0F;

/// Pixels that are shaded together.
constexpr std::ptrdiff_t kBlock = 64;
constexpr std::ptrdiff_t kBlockSamples = kBlock * kSamplesPerPixel;

using Block = std::array<float, kBlock>;
using SampleBlock = std::array<float, kBlockSamples>;
/// With one sample more at each end.
using WideBlock = std::array<float, kBlockSamples + 2>;

struct Direction {
  float right, up, near;
};
Direction unit(float right, float up, float near) {
  const float length = std::sqrt(right * right + up * up + near * near);
  return {right / length, up / length, near / length};
}

// The lamp hangs in front, above, to the left.
const Direction kKey = unit(-0.55F, 0.62F, 0.62F);
const Direction kFill = unit(0.85F, 0.10F, 0.50F);
const Direction kHalfway = unit(-0.55F, 0.62F, 1.66F);

/// The depth of each pixel's first sample that shows something. Shadows are soft: followed over pixels, not over samples, they look the
/// same and take a fraction of the time.
struct PixelMap {
  const float* depth;
  const float* shading;  ///< empty where what is seen casts no shadow
  std::ptrdiff_t columns, rows;
};

/// From a pixel to another one.
struct Step {
  std::ptrdiff_t columns = 0, rows = 0;
  float way = 0;  ///< samples
};

/// What is looked at from each pixel.
struct Steps {
  Steps() {
    constexpr std::array<std::array<std::ptrdiff_t, 2>, 8> kDirections{
        {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};
    constexpr std::array<std::ptrdiff_t, 4> kReach{3, 7, 14, 26}, kDiagonalReach{2, 4, 7, 13};
    for (std::size_t d = 0; d < kDirections.size(); ++d) {
      const auto& [x, y] = kDirections[d];
      const bool is_straight = x * y == 0;
      for (std::size_t k = 0; k < kReach.size(); ++k) {
        const std::ptrdiff_t reach = (is_straight ? kReach : kDiagonalReach)[k];
        around[d][k] = {x * reach, y * reach,
                        (is_straight ? 1.0F : 1.41421356F) * float{kSamplesPerPixel} * static_cast<float>(reach)};
      }
    }
    // Pixels that lie close to the lamp's ray, the closer the nearer: where the surface turns away, others would shade what is lit.
    const float across = std::sqrt(1.0F - kKey.near * kKey.near);
    float least = 0.0F;
    for (float columns = 1.0F; lamp_count < lamp.size() && least < 200.0F; ++columns) {
      const float rows = std::floor(columns * kKey.up / -kKey.right + 0.5F);
      const float beside = std::abs(columns * kKey.up + rows * kKey.right) / across;
      const float way = float{kSamplesPerPixel} * std::sqrt(columns * columns + rows * rows) / across;
      if (beside > 0.1F * std::sqrt(way) || way < least) continue;
      lamp[lamp_count++] = {-static_cast<std::ptrdiff_t>(columns), -static_cast<std::ptrdiff_t>(rows), way};
      least = 1.1F * way;
    }
  }

  std::array<std::array<Step, 4>, 8> around;
  std::array<Step, 32> lamp;  ///< towards the lamp
  std::size_t lamp_count = 0;
};

/// The pixels of a block that lie on the map after a step.
struct Reached {
  Reached(const PixelMap& map, std::ptrdiff_t row, std::ptrdiff_t column, std::ptrdiff_t count, const Step& step)
      : begin(std::max<std::ptrdiff_t>(0, -(column + step.columns))),
        end(std::min(count, map.columns - column - step.columns)),
        depth(map.shading + (row + step.rows) * map.columns + column + step.columns) {}
  std::ptrdiff_t begin, end;
  const float* depth;  ///< seen from each of them
};

/// Shares of the ambient light and of the lamp's light that reach pixels, 0 to 1.
/// @param open  by sample: 1 on a free plane, less in creases, from how high the surroundings rise in eight directions
/// @param lamp  by sample: 0 in shadow, 1 in light, in between where the lamp is partly hidden
PLUMBLINE_WIDE void measure_light(const PixelMap& map, const Steps& steps, std::ptrdiff_t row, std::ptrdiff_t column,
                                  std::ptrdiff_t count, SampleBlock& open, SampleBlock& lamp) {
  const float* const here = map.depth + row * map.columns + column;
  Block closed{};
  for (const auto& direction : steps.around) {
    Block steepest{};
    for (const Step& step : direction) {
      if (row + step.rows < 0 || row + step.rows >= map.rows) continue;
      const Reached reached(map, row, column, count, step);
      const float per_way = 1.0F / step.way;
      for (std::ptrdiff_t i = reached.begin; i < reached.end; ++i) {
        // Where nothing is, the depth is so large that it rises nowhere. A high step in front is another part of the object, which
        // shades less than a wall would.
        const float rise = std::min((here[i] - reached.depth[i]) * per_way, 2.0F);
        steepest[static_cast<std::size_t>(i)] = std::max(steepest[static_cast<std::size_t>(i)], rise);
      }
    }
    // The sine of the horizon's height.
    for (std::size_t i = 0; i < kBlock; ++i) closed[i] += steepest[i] / std::sqrt(1.0F + steepest[i] * steepest[i]);
  }

  constexpr float kSoftness = 7.0F;
  Block light;
  light.fill(1.0F);
  for (std::size_t k = 0; k < steps.lamp_count; ++k) {
    const Step& step = steps.lamp[k];
    if (row + step.rows < 0) break;
    const Reached reached(map, row, column, count, step);
    const float per_way = 0.5F * kSoftness / step.way, nearer = kKey.near * step.way + 1.0F;
    for (std::ptrdiff_t i = reached.begin; i < reached.end; ++i) {
      const float passing = 0.5F + (reached.depth[i] - here[i] + nearer) * per_way;
      light[static_cast<std::size_t>(i)] = std::min(light[static_cast<std::size_t>(i)], passing);
    }
  }
  for (std::size_t i = 0; i < kBlock; ++i) {
    const float l = std::max(light[i], 0.0F);
    const float reaches = l * l * (3.0F - 2.0F * l), free = std::max(1.0F - 0.85F * closed[i] / 8.0F, 0.0F);
    for (std::size_t k = 0; k < kSamplesPerPixel; ++k) {
      lamp[i * kSamplesPerPixel + k] = reaches;
      open[i * kSamplesPerPixel + k] = free;
    }
  }
}

/// Slopes at samples, from the neighbours that belong to their surfaces.
PLUMBLINE_INLINE void slope_lanes(Lanes& slope, const float* before, const float* here, const float* after) {
  Lanes a, b, c, half;
  load(a, before);
  load(b, here);
  load(c, after);
  const Lanes down = b - a, up = c - b, none = Lanes{} + 0.0F;
  const IntLanes has_down = (down < none + kJump) & (down > none - kJump);
  const IntLanes has_up = (up < none + kJump) & (up > none - kJump);
  Lanes of_down, of_up;
  choose(of_down, has_down, down, none);
  choose(of_up, has_up, up, none);
  choose(half, has_down & has_up, none + 0.5F, none + 1.0F);
  slope = (of_down + of_up) * half;
}

/// Cosines of the angles between normals and a direction; 0 behind.
PLUMBLINE_INLINE void cosine_lanes(Lanes& cosine, const Direction& a, const Lanes& right, const Lanes& up,
                                   const Lanes& near) {
  const Lanes none = Lanes{} + 0.0F, along = right * a.right + up * a.up + near * a.near;
  choose(cosine, along > none, along, none);
}

/// Brightness of samples that show the object, 0 to 1.
/// @param depth          the samples of the line, from the one before the first on
/// @param above, below   of the lines next to it
/// @param open, lamp     light that reaches them
PLUMBLINE_WIDE void light_samples(const WideBlock& depth, const WideBlock& above, const WideBlock& below,
                                  const SampleBlock& open, const SampleBlock& lamp, SampleBlock& brightness) {
  static_assert(kBlockSamples % kLanes == 0);
  const Lanes none = Lanes{} + 0.0F;
  for (std::size_t i = 0; i < kBlockSamples; i += kLanes) {
    Lanes right, up, length, key, fill, shine, reaching, free;
    slope_lanes(right, &depth[i], &depth[i + 1], &depth[i + 2]);
    slope_lanes(up, &below[i + 1], &depth[i + 1], &above[i + 1]);
    square_root(length, right * right + up * up + 1.0F);
    const Lanes near = (none + 1.0F) / length;  // of the normal
    right *= near;
    up *= near;
    cosine_lanes(key, kKey, right, up, near);
    cosine_lanes(fill, kFill, right, up, near);
    cosine_lanes(shine, kHalfway, right, up, near);
    load(reaching, &lamp[i]);
    load(free, &open[i]);
    key *= reaching;
    const Lanes sky = up * 0.5F + 0.5F;
    const Lanes shine2 = shine * shine, shine4 = shine2 * shine2, shine8 = shine4 * shine4;
    Lanes linear = free * (sky * 0.14F + fill * 0.13F + 0.10F) + key * 0.62F + key * shine8 * shine8 * 0.07F;
    choose(linear, linear < none + 1.0F, linear, none + 1.0F);
    square_root(linear, linear);  // to the screen: a gamma of 2
    store(&brightness[i], linear);
  }
}

/// Samples of a line from the one before `first` on; empty outside the map.
void take_samples(const DepthMap& map, std::ptrdiff_t row, std::ptrdiff_t first, WideBlock& samples) {
  samples.fill(DepthMap::kEmpty);
  if (row < 0 || row >= static_cast<std::ptrdiff_t>(map.rows)) return;
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(first - 1, 0);
  const std::ptrdiff_t end = std::min(first + kBlockSamples + 1, static_cast<std::ptrdiff_t>(map.columns));
  std::copy_n(map.depth.begin() + row * static_cast<std::ptrdiff_t>(map.columns) + begin, end - begin,
              samples.begin() + (begin - (first - 1)));
}

/// The samples of a pixel, row after row, in the map.
struct PixelSamples {
  PixelSamples(const DepthMap& map, std::ptrdiff_t column, std::ptrdiff_t row) {
    static_assert(kSamplesPerPixel == 2);
    const std::size_t first = static_cast<std::size_t>(2 * row) * map.columns + static_cast<std::size_t>(2 * column);
    at = {first, first + 1, first + map.columns, first + map.columns + 1};
  }
  std::array<std::size_t, 4> at;
};

/// The depth of the first sample of each pixel of a row that shows something, and the same of what casts shadows.
void take_first_depths(const DepthMap& map, std::optional<std::uint8_t> shadowless, std::ptrdiff_t row,
                       std::span<float> depths, std::span<float> shading) {
  for (std::size_t column = 0; column < depths.size(); ++column) {
    const PixelSamples samples(map, static_cast<std::ptrdiff_t>(column), row);
    depths[column] = shading[column] = DepthMap::kEmpty;
    for (std::size_t k = samples.at.size(); k-- > 0;) {
      const float sample = map.depth[samples.at[k]];
      if (sample == DepthMap::kEmpty) continue;
      depths[column] = sample;
      if (map.material[samples.at[k]] != shadowless) shading[column] = sample;
    }
  }
}

/// The colour of a pixel, and how much of it the object covers.
/// @param bright  of its samples, row after row
std::pair<Rgb, float> mixed(const DepthMap& map, const PixelSamples& samples, const std::array<float, 4>& bright,
                            std::span<const Rgb> materials) {
  std::array<float, 3> sum = {};
  float shown = 0;
  for (std::size_t k = 0; k < samples.at.size(); ++k) {
    if (map.depth[samples.at[k]] == DepthMap::kEmpty) continue;
    const Rgb& colour = materials[map.material[samples.at[k]]];
    for (std::size_t c = 0; c < 3; ++c) sum[c] += bright[k] * static_cast<float>(colour[c]);
    ++shown;
  }
  const float share = 1.0F / shown;
  const auto level = [share](float of) { return static_cast<std::uint8_t>(of * share); };
  return {{level(sum[0]), level(sum[1]), level(sum[2])}, shown / static_cast<float>(samples.at.size())};
}

}  // namespace

void shade_depth(const DepthMap& map, std::span<float> scratch, const Picture& picture, std::int64_t left,
                 std::int64_t top, std::span<const Rgb> materials, std::optional<std::uint8_t> shadowless) {
  assert(map.columns % kSamplesPerPixel == 0 && map.rows % kSamplesPerPixel == 0);
  const std::ptrdiff_t columns = map.columns / kSamplesPerPixel, rows = map.rows / kSamplesPerPixel;
  const Steps steps;
  const auto of_pixels = static_cast<std::size_t>(columns * rows);
  const PixelMap pixels{scratch.data(), scratch.data() + of_pixels, columns, rows};
#pragma omp parallel
  {
#pragma omp for schedule(static)
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
      const auto first = static_cast<std::size_t>(row * columns), count = static_cast<std::size_t>(columns);
      take_first_depths(map, shadowless, row, scratch.subspan(first, count), scratch.subspan(of_pixels + first, count));
    }
#pragma omp for schedule(dynamic, 8)
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
      for (std::ptrdiff_t first = 0; first < columns; first += kBlock) {
        const std::ptrdiff_t count = std::min(kBlock, columns - first);
        const float* const depths = pixels.depth + row * columns + first;
        if (std::all_of(depths, depths + count, [](float depth) { return depth == DepthMap::kEmpty; })) continue;
        SampleBlock open, lamp;
        measure_light(pixels, steps, row, first, count, open, lamp);
        std::array<WideBlock, kSamplesPerPixel + 2> lines;
        for (std::size_t k = 0; k < lines.size(); ++k) {
          take_samples(map, row * kSamplesPerPixel + static_cast<std::ptrdiff_t>(k) - 1, first * kSamplesPerPixel,
                       lines[k]);
        }
        std::array<SampleBlock, kSamplesPerPixel> brightness;
        for (std::size_t k = 0; k < brightness.size(); ++k) {
          light_samples(lines[k + 1], lines[k], lines[k + 2], open, lamp, brightness[k]);
        }
        for (std::ptrdiff_t i = 0; i < count; ++i) {
          if (depths[i] == DepthMap::kEmpty) continue;
          const auto x = static_cast<std::size_t>(i) * kSamplesPerPixel;
          const auto [colour, cover] =
              mixed(map, PixelSamples(map, first + i, row),
                    {brightness[0][x], brightness[0][x + 1], brightness[1][x], brightness[1][x + 1]}, materials);
          picture.blend(left + first + i, top + row, colour, cover);
        }
      }
    }
  }
}

}  // namespace plumbline::firmware::inline pictures
