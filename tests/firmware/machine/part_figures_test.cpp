#include "firmware/machine/part_figures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace plumbline::firmware {
namespace {

TEST(PartFigures, SumUpDeviationsByTheKindOfSurface) {
  const auto facing = [](float up) { return OrientedPoint{{}, {std::sqrt(1 - up * up), 0, up}}; };
  const std::vector<OrientedPoint> points = {facing(-1),   facing(-0.51F), facing(-0.49F), facing(0.49F),
                                             facing(0.6F), facing(0.87F),  facing(1)};
  const std::vector<float> mm = {0.3F, 0.1F, 0.01F, 0.03F, 0.5F, 0.03F, -0.04F};
  const auto figures = deviation_figures("ball.stl", points, mm);
  EXPECT_NEAR(figures.down_mean, 200, 1e-3);
  EXPECT_NEAR(figures.down_rms, 100, 1e-3);
  EXPECT_NEAR(figures.wall_mean, 20, 1e-3);
  EXPECT_NEAR(figures.wall_rms, 10, 1e-3);
  EXPECT_NEAR(figures.top_rms, std::sqrt((900 + 1600) / 2.0), 1e-3);
  EXPECT_NEAR(figures.rms, std::sqrt((90000 + 10000 + 100 + 900 + 250000 + 900 + 1600) / 7.0), 1e-3);
}

TEST(PartFigures, CountWhatHasNoSurfaceInReach) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<OrientedPoint> points(4);
  const auto figures = deviation_figures("r-rep", points, std::vector<float>{kInfinity, -kInfinity, kInfinity, 0.05F});
  EXPECT_EQ(figures.points, 4U);
  EXPECT_EQ(figures.missing, 3U);
  EXPECT_EQ(figures.sealed, 2U);
  EXPECT_NEAR(figures.rms, 50, 1e-3);
  EXPECT_TRUE(std::isnan(figures.wall_mean));
}

}  // namespace
}  // namespace plumbline::firmware
