#include "hal/sim/part/layer_light.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "slicer/core/bit_spans.hpp"

namespace plumbline {
namespace {

constexpr std::uint32_t kLightColumns = 150, kLightRows = 20;

struct LitMask {
  std::vector<std::uint64_t> words = std::vector<std::uint64_t>(BitImage::words_needed(kLightColumns, kLightRows));
  std::vector<GreyRun> greys;

  BitImage image() { return {words, kLightColumns, kLightRows}; }
};

/// Levels of all pixels, 0 to 255.
std::vector<double> lit_levels(ConstBitImage image, std::span<const GreyRun> greys) {
  std::vector<double> levels;
  for (std::uint32_t y = 0; y < kLightRows; ++y) {
    for (std::uint32_t x = 0; x < kLightColumns; ++x) levels.push_back(image.at(x, y) ? 255 : 0);
  }
  for (const GreyRun& run : greys) {
    for (std::uint32_t pixel = run.pixel; pixel < run.end(); ++pixel) levels[pixel] = run.level;
  }
  return levels;
}

TEST(LayerLight, AddsDosesPixelByPixel) {
  std::minstd_rand random(3);
  const auto below = [&random](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  for (int trial = 0; trial < 20; ++trial) {
    LayerLight light(kLightColumns, kLightRows);
    std::vector<double> sums(kLightColumns * kLightRows);
    double dose = 0;
    for (int k = 0; k < 5; ++k) {
      LitMask mask;
      for (std::uint32_t y = 0; y < kLightRows; ++y) {
        fill(mask.image(), y, 20 + below(9), 90 + below(40), true);
        if (k % 2 == 1) {
          mask.greys.push_back({y * kLightColumns + 10, 15, static_cast<std::uint8_t>(1 + below(254))});
          mask.greys.push_back({y * kLightColumns + 140, 10, static_cast<std::uint8_t>(1 + below(254))});
        }
      }
      const double its = 1 + below(7);
      EXPECT_TRUE(light.add(mask.image(), mask.greys, Dose(its / 2)));
      EXPECT_FALSE(light.add(mask.image(), mask.greys, Dose(its / 2))) << "the same mask";
      const auto levels = lit_levels(mask.image(), mask.greys);
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += its * levels[i];
      dose += its;
    }
    LitMask found;
    light.combine(found.image(), found.greys);
    const auto levels = lit_levels(found.image(), found.greys);
    for (std::size_t i = 0; i < sums.size(); ++i) ASSERT_EQ(levels[i], std::round(sums[i] / dose)) << i;
    for (std::size_t i = 1; i < found.greys.size(); ++i) {
      ASSERT_GE(found.greys[i].pixel, found.greys[i - 1].end());
      ASSERT_TRUE(is_grey(found.greys[i].level));
    }
  }
}

TEST(LayerLight, OfOneMaskIsThatMask) {
  LayerLight light(kLightColumns, kLightRows);
  LitMask before, mask, found;
  fill(before.image(), 1, 0, kLightColumns, true);
  fill(mask.image(), 3, 5, 100, true);
  mask.greys = {{20, 3, 7}};
  light.add(before.image(), {}, Dose(1));
  light.clear();
  EXPECT_TRUE(light.add(mask.image(), mask.greys, Dose(1)));
  light.combine(found.image(), found.greys);
  EXPECT_EQ(found.words, mask.words);
  EXPECT_EQ(found.greys, mask.greys);
}

}  // namespace
}  // namespace plumbline
