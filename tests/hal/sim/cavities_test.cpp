/// Closed cavities against a flood of the air in three dimensions.

#include "hal/sim/part/cavities.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

namespace plumbline {
namespace {

TEST(Cavities, HoldWhatBruteForceFindsEnclosed) {
  // Random solids with bubbles. A flood of the air in three dimensions from the outside and from the open end leaves the traps.
  std::mt19937 random(6);
  constexpr std::uint32_t kSide = 40;
  constexpr std::uint32_t kLayers = 30;
  for (int run = 0; run < 30; ++run) {
    std::vector<std::array<double, 4>> bubbles;
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 45; ++i)
      bubbles.push_back({40 * unit(random), 40 * unit(random), 30 * unit(random), 1.5 + 3 * unit(random)});
    const auto solid = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
      if (x < 2 || y < 2 || x > 37 || y > 37) return false;
      for (const auto& b : bubbles) {
        if ((x - b[0]) * (x - b[0]) + (y - b[1]) * (y - b[1]) + (z - b[2]) * (z - b[2]) < b[3] * b[3]) return false;
      }
      return true;
    };
    Cavities cavities;
    PartRegions before;
    PartRegions here;
    std::vector<bool> air(kSide * kSide * kLayers);
    for (std::uint32_t z = 0; z < kLayers; ++z) {
      std::vector<std::uint64_t> words(BitImage::words_needed(kSide, kSide), 0);
      for (std::uint32_t y = 0; y < kSide; ++y) {
        for (std::uint32_t x = 0; x < kSide; ++x) {
          air[(z * kSide + y) * kSide + x] = !solid(x, y, z);
          if (solid(x, y, z)) BitImage(words, kSide, kSide).set(x, y);
        }
      }
      std::swap(before, here);
      here.find(ConstBitImage(words, kSide, kSide));
      cavities.next_layer(before, here, z == 0, z, 1);
    }
    std::vector<bool> open(air.size());
    std::vector<std::size_t> todo;
    const auto visit = [&](std::size_t at) {
      if (!air[at] || open[at]) return;
      open[at] = true;
      todo.push_back(at);
    };
    for (std::size_t i = 0; i < std::size_t{kSide} * kSide; ++i) {
      visit(i);
      visit(air.size() - 1 - i);
    }
    for (std::uint32_t z = 0; z < kLayers; ++z) visit(std::size_t{z} * kSide * kSide);
    while (!todo.empty()) {
      const std::size_t at = todo.back();
      todo.pop_back();
      const std::size_t x = at % kSide;
      const std::size_t y = at / kSide % kSide;
      if (x > 0) visit(at - 1);
      if (x + 1 < kSide) visit(at + 1);
      if (y > 0) visit(at - kSide);
      if (y + 1 < kSide) visit(at + kSide);
      if (at >= kSide * kSide) visit(at - kSide * kSide);
      if (at + kSide * kSide < air.size()) visit(at + kSide * kSide);
    }
    double enclosed = 0;
    for (std::size_t i = 0; i < air.size(); ++i) enclosed += air[i] && !open[i] ? 1 : 0;
    EXPECT_EQ(cavities.trapped_mm3(), enclosed) << run;
  }
}

}  // namespace
}  // namespace plumbline
