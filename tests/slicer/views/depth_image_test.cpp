#include "slicer/views/depth_image.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

const DepthFrame kFrame({5, -3, 2}, Vec3d(0.6, 0, 0.8), 20);  // mm

/// Image of a bowl with a circular outline, with `waves` and noise in depth.
struct Bowl {
  std::vector<DepthImage::Cell> cells = std::vector<DepthImage::Cell>(DepthImage::kCells);
  DepthImage image{kFrame, cells};

  Bowl(const std::vector<Wave>& waves, double noise, std::uint32_t seed) {
    Random random(seed);
    for (int k = 0; k < 20000; ++k) {
      const double u = 38 * random.uniform() - 19;
      const double v = 38 * random.uniform() - 19;
      if (u * u + v * v > 19 * 19) continue;
      const Vec3d x = kFrame.middle + kFrame.right * u + kFrame.up * v + kFrame.axis * (0.02 * (u * u + v * v));
      double offset = noise * random.normal();
      for (const Wave& wave : waves) offset += wave.depth(x);
      image.add(x, 2 * offset, 2);
    }
  }
};

TEST(WaveSearch, FindsWavesBelowTheNoise) {
  ArenaBlock block(kMiB);
  WaveSearch search = value_of(WaveSearch::create(*block));
  const std::vector<Wave> waves = {{kFrame.right * 0.2 + kFrame.up * 0.07, 0.01, -0.006},
                                   {kFrame.right * 0.05 - kFrame.up * 0.13 + kFrame.axis * 0.01, -0.003, 0.009}};
  Bowl bowl(waves, 0.03, 1);
  Ripple ripple;
  for (int k = 0; k < 3; ++k) search.improve(ripple, bowl.image);
  ASSERT_EQ(ripple.waves, 2U);
  double worst = 0;
  for (double u = -12; u <= 12; u += 1.5) {
    for (double v = -12; v <= 12; v += 1.5) {
      const Vec3d x = kFrame.middle + kFrame.right * u + kFrame.up * v + kFrame.axis * (0.02 * (u * u + v * v));
      worst = std::max(worst, std::abs(ripple.depth(x) - waves[0].depth(x) - waves[1].depth(x)));
    }
  }
  EXPECT_LT(worst, 0.003) << "of 0.02 mm";
}

TEST(WaveSearch, FindsNothingInNoise) {
  ArenaBlock block(kMiB);
  WaveSearch search = value_of(WaveSearch::create(*block));
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    Bowl bowl({}, 0.05, seed);
    Ripple ripple;
    search.improve(ripple, bowl.image);
    EXPECT_EQ(ripple.waves, 0U);
  }
}

}  // namespace
}  // namespace plumbline
