#include "firmware/pictures/preview/preview_smoothing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace plumbline::firmware {
namespace {

/// One pass over one line, sample by sample: opposite neighbours in pairs, until a pair bends more than voxels do or is an edge.
std::vector<float> smoothed_line(const std::vector<float>& line, const VoxelSize& voxel) {
  constexpr float kSteepest = 6.0F;
  const auto reach = static_cast<int>(std::clamp(2.2F * voxel.across, std::min(4.0F, 4.0F * voxel.across), 40.0F));
  const int stride = std::max(reach / 6, 1), end = static_cast<int>(line.size());
  std::vector<float> to = line;
  for (int here = 0; here < end; ++here) {
    const float depth = line[static_cast<std::size_t>(here)];
    if (depth == DepthMap::kEmpty) continue;
    float weight = static_cast<float>(reach + 1), sum = depth * weight;
    for (int k = stride; k <= reach && here >= k && here + k < end; k += stride) {
      const float a = line[static_cast<std::size_t>(here - k)], b = line[static_cast<std::size_t>(here + k)];
      const float way = static_cast<float>(k), rise = std::abs(a - b);
      const float bend = std::abs(a + b - 2.0F * depth) - 2.0F * voxel.deep;
      if (bend * way > rise * voxel.across || rise > kSteepest * (way + voxel.across)) break;
      const float w = static_cast<float>(reach + 1 - k);
      sum += w * (a + b);
      weight += 2.0F * w;
    }
    to[static_cast<std::size_t>(here)] = sum / weight;
  }
  return to;
}

/// Two passes, each along rows, then along columns.
std::vector<float> smoothed(std::vector<float> map, std::size_t columns, std::size_t rows, const VoxelSize& voxel) {
  for (int pass = 0; pass < 4; ++pass) {
    const bool along_rows = pass % 2 == 0;
    const std::size_t step = along_rows ? 1 : columns, length = along_rows ? columns : rows;
    for (std::size_t l = 0; l < map.size() / length; ++l) {
      const std::size_t begin = along_rows ? l * columns : l;
      std::vector<float> line(length);
      for (std::size_t k = 0; k < length; ++k) line[k] = map[begin + k * step];
      line = smoothed_line(line, voxel);
      for (std::size_t k = 0; k < length; ++k) map[begin + k * step] = line[k];
    }
  }
  return map;
}

TEST(SmoothDepth, AveragesAsItsFormulaDoesInMapsOfAnySize) {
  std::mt19937 dice(7);
  for (const std::uint32_t columns : {1U, 3U, 8U, 13U, 90U}) {
    for (const std::uint32_t rows : {1U, 5U, 61U}) {
      for (const float across : {0.4F, 2.6F, 30.0F}) {
        std::vector<float> depth(std::size_t{columns} * rows);
        for (std::size_t i = 0; i < depth.size(); ++i) {
          // A slope in steps, with an edge, noise and holes.
          const auto x = static_cast<float>(i % columns), y = static_cast<float>(i / columns);
          depth[i] = std::floor((0.7F * x + 0.3F * y) / across) * across + (x > 50 ? 90.0F : 0.0F);
          if (dice() % 9 == 0) depth[i] += static_cast<float>(dice() % 100) / 50;
          if (dice() % 13 == 0) depth[i] = DepthMap::kEmpty;
        }
        const VoxelSize voxel{.across = across, .deep = across};
        const auto expected = smoothed(depth, columns, rows, voxel);
        std::vector<float> scratch(depth.size());
        std::vector<std::uint8_t> material(depth.size());
        smooth_depth({depth, material, columns, rows}, scratch, voxel);
        ASSERT_EQ(depth, expected) << columns << " x " << rows << ", voxels of " << across;
      }
    }
  }
}

}  // namespace
}  // namespace plumbline::firmware
