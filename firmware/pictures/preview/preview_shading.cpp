#include "firmware/pictures/preview/preview_shading.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace plumbline {
namespace {

/// Slope up to which two samples belong to one surface: 81 degrees. Steeper steps are edges and stay sharp.
constexpr float kSteepest = 6.0F;

using Signed = std::int64_t;

/// Smooths once, along rows or along columns.
void smooth_once(const DepthMap& from, std::span<float> to, const VoxelSize& voxel, bool along_rows) {
  const float least = std::min(4.0F, 4.0F * voxel.across);
  const auto reach = static_cast<Signed>(std::clamp(2.2F * voxel.across, least, 40.0F));
  // Within a voxel of many samples all are alike: a few pairs will do.
  const Signed stride = std::max<Signed>(reach / 6, 1);
  const Signed columns = from.columns, rows = from.rows;
  const Signed step = along_rows ? 1 : columns;
#pragma omp parallel for schedule(static)
  for (Signed row = 0; row < rows; ++row) {
    for (Signed column = 0; column < columns; ++column) {
      const Signed here = row * columns + column;
      const float depth = from.depth[static_cast<std::size_t>(here)];
      if (depth == DepthMap::kEmpty) {
        to[static_cast<std::size_t>(here)] = depth;
        continue;
      }
      const Signed position = along_rows ? column : row, end = along_rows ? columns : rows;
      float sum = depth * static_cast<float>(reach + 1), weight = static_cast<float>(reach + 1);
      // Average opposite neighbours in pairs, which leaves slopes unchanged. A pair that bends more than the steps do
      // ends the average: that bend belongs to the object.
      for (Signed k = stride; k <= reach && position >= k && position + k < end; k += stride) {
        const float a = from.depth[static_cast<std::size_t>(here - k * step)];
        const float b = from.depth[static_cast<std::size_t>(here + k * step)];
        const float way = static_cast<float>(k), rise = std::abs(a - b);
        const float bend = std::abs(a + b - 2.0F * depth) - 2.0F * voxel.deep;
        if (bend * way > rise * voxel.across || rise > kSteepest * (way + voxel.across)) break;
        const float w = static_cast<float>(reach + 1 - k);
        sum += w * (a + b);
        weight += 2.0F * w;
      }
      to[static_cast<std::size_t>(here)] = sum / weight;
    }
  }
}

struct Direction {
  float right, up, near;
};
Direction unit(float right, float up, float near) {
  const float length = std::sqrt(right * right + up * up + near * near);
  return {right / length, up / length, near / length};
}
float dot(const Direction& a, const Direction& b) { return a.right * b.right + a.up * b.up + a.near * b.near; }

class Shader {
 public:
  explicit Shader(const DepthMap& map) : map_(map) {
    float way = 3.0F;
    for (Step& step : towards_lamp_) {
      const auto nearest = [](float x) { return static_cast<Signed>(x < 0 ? x - 0.5F : x + 0.5F); };
      step = {nearest(kKey.right * way), nearest(-kKey.up * way), way, 1.0F / way};
      way *= 1.22F;
    }
    constexpr std::array<std::array<Signed, 2>, 8> kDirections{
        {{2, 0}, {-2, 0}, {0, 2}, {0, -2}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};
    constexpr std::array<Signed, 4> kReach{3, 7, 14, 26};
    for (std::size_t d = 0; d < kDirections.size(); ++d) {
      const auto& [x, y] = kDirections[d];
      for (std::size_t k = 0; k < kReach.size(); ++k) {
        const float length = (x * y == 0 ? 2.0F : 1.41421356F) * static_cast<float>(kReach[k]);
        around_[d][k] = {x * kReach[k], y * kReach[k], length, 1.0F / length};
      }
    }
  }

  /// Shares of the ambient light and of the lamp's light that reach a sample, 0 to 1.
  struct Reaching {
    float open, lamp;
  };
  Reaching reaching(Signed column, Signed row) const {
    const float depth = *sample(column, row);
    return {openness(column, row, depth), light_reaching(column, row, depth)};
  }

  /// Brightness of a sample that shows the object, 0 to 1.
  float brightness(Signed column, Signed row, const Reaching& reaching) const {
    const auto [open, lamp] = reaching;
    const Direction normal = this->normal(column, row, *sample(column, row));
    const float key = std::max(dot(normal, kKey), 0.0F) * lamp;
    const float fill = std::max(dot(normal, kFill), 0.0F);
    const float sky = 0.5F + 0.5F * normal.up;
    const float shine = std::max(dot(normal, kHalfway), 0.0F);
    const float shine2 = shine * shine, shine8 = shine2 * shine2 * shine2 * shine2;
    const float linear = open * (0.10F + 0.14F * sky + 0.13F * fill) + 0.62F * key + 0.07F * key * shine8 * shine8;
    return std::sqrt(std::min(linear, 1.0F));  // to the screen: a gamma of 2
  }

  bool shows(Signed column, Signed row) const { return sample(column, row) != nullptr; }

 private:
  // The lamp hangs in front, above, to the left.
  static inline const Direction kKey = unit(-0.55F, 0.62F, 0.62F);
  static inline const Direction kFill = unit(0.85F, 0.10F, 0.50F);
  static inline const Direction kHalfway = unit(-0.55F, 0.62F, 1.66F);

  /// @returns nullptr outside the map and at empty samples
  const float* sample(Signed column, Signed row) const {
    if (column < 0 || row < 0 || column >= map_.columns || row >= map_.rows) return nullptr;
    const float& depth = map_.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row));
    return depth == DepthMap::kEmpty ? nullptr : &depth;
  }

  /// Slope at a sample, from the neighbours that belong to its surface.
  static float slope(const float* before, float here, const float* after) {
    constexpr float kJump = 1.5F * kSteepest;
    const bool has_before = before && std::abs(*before - here) < kJump;
    const bool has_after = after && std::abs(*after - here) < kJump;
    if (has_before && has_after) return 0.5F * (*after - *before);
    if (has_before) return here - *before;
    return has_after ? *after - here : 0.0F;
  }

  Direction normal(Signed column, Signed row, float depth) const {
    const float right = slope(sample(column - 1, row), depth, sample(column + 1, row));
    const float up = slope(sample(column, row + 1), depth, sample(column, row - 1));
    return unit(right, up, 1.0F);
  }

  /// 1 on a free plane, less in creases, from how high the surroundings rise in eight directions.
  float openness(Signed column, Signed row, float depth) const {
    float closed = 0.0F;
    for (const auto& direction : around_) {
      float steepest = 0.0F;
      for (const Step& step : direction) {
        const Signed x = column + step.columns, y = row + step.rows;
        if (!is_inside(x, y)) continue;
        // Where nothing is, the depth is so large that it rises nowhere. A high step in front is another part of the object, which
        // shades less than a wall would.
        const float rise =
            (depth - map_.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y))) * step.per_way;
        steepest = std::max(steepest, std::min(rise, 2.0F));
      }
      if (steepest > 0.0F) closed += steepest / std::sqrt(1.0F + steepest * steepest);  // sine of the horizon's height
    }
    return std::max(1.0F - 0.85F * closed / 8.0F, 0.0F);
  }

  /// 0 in shadow, 1 in light, in between where the lamp is partly hidden. Marches over the map towards the lamp.
  float light_reaching(Signed column, Signed row, float depth) const {
    constexpr float kSoftness = 7.0F;
    float light = 1.0F;
    for (const Step& step : towards_lamp_) {
      const Signed x = column + step.columns, y = row + step.rows;
      if (!is_inside(x, y)) break;
      const float other = map_.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
      const float clearance = other - (depth - kKey.near * step.way) + 1.0F;
      light = std::min(light, 0.5F + 0.5F * kSoftness * clearance * step.per_way);
      if (light <= 0.0F) return 0.0F;
    }
    return light * light * (3.0F - 2.0F * light);
  }

  bool is_inside(Signed column, Signed row) const {
    return static_cast<std::uint64_t>(column) < map_.columns && static_cast<std::uint64_t>(row) < map_.rows;
  }

  struct Step {
    Signed columns = 0, rows = 0;
    float way = 0, per_way = 0;  ///< samples from the start, along the ray; 1 / way
  };
  const DepthMap& map_;
  std::array<std::array<Step, 4>, 8> around_;
  std::array<Step, 22> towards_lamp_;
};

}  // namespace

void smooth_depth(const DepthMap& map, std::span<float> scratch, const VoxelSize& voxel) {
  const DepthMap other{scratch.first(map.depth.size()), map.material, map.columns, map.rows};
  for (int pass = 0; pass < 2; ++pass) {
    smooth_once(map, other.depth, voxel, true);
    smooth_once(other, map.depth, voxel, false);
  }
}

void shade_depth(const DepthMap& map, const Picture& picture, std::int64_t left, std::int64_t top,
                 std::span<const Colour> materials, Shades shades) {
  const Shader shader(map);
  const Signed columns = (Signed{map.columns} + kSamplesPerPixel - 1) / kSamplesPerPixel;
  const Signed rows = (Signed{map.rows} + kSamplesPerPixel - 1) / kSamplesPerPixel;
#pragma omp parallel for schedule(dynamic, 8)
  for (Signed row = 0; row < rows; ++row) {
    for (Signed column = 0; column < columns; ++column) {
      std::array<float, 3> sum = {};
      std::uint32_t shown = 0;
      float brightness = 0;
      Shader::Reaching reaching{};  // once a pixel: shadows are soft, and to follow them takes most of the time
      for (std::uint32_t k = 0; k < kSamplesPerPixel * kSamplesPerPixel; ++k) {
        const Signed x = column * kSamplesPerPixel + k % kSamplesPerPixel;
        const Signed y = row * kSamplesPerPixel + k / kSamplesPerPixel;
        if (!shader.shows(x, y)) continue;
        if (shown == 0) reaching = shader.reaching(x, y);
        if (shown == 0 || shades == Shades::kEverySample) brightness = shader.brightness(x, y, reaching);
        const std::size_t sample = static_cast<std::size_t>(y) * map.columns + static_cast<std::size_t>(x);
        for (std::size_t c = 0; c < 3; ++c)
          sum[c] += brightness * static_cast<float>(materials[map.material[sample]][c]);
        ++shown;
      }
      if (shown == 0) continue;
      Colour colour;
      for (std::size_t c = 0; c < 3; ++c) colour[c] = static_cast<std::uint8_t>(sum[c] / static_cast<float>(shown));
      picture.blend(left + column, top + row, colour,
                    static_cast<float>(shown) / (kSamplesPerPixel * kSamplesPerPixel));
    }
  }
}

}  // namespace plumbline
