#include "firmware/print/truth/true_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware/print/truth/rrep_surface.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline::firmware {
namespace {

TEST(TrueSurface, OfAnRRepIsThatOfItsBall) {
  for (const float layer_mm : {0.05F, 0.1F}) {
    PrintGrid grid = testing::cubic_grid(240, static_cast<std::uint32_t>(std::lround(12 / layer_mm)), 0.05F);
    grid.layer_height_mm = layer_mm;
    const double tall = static_cast<double>(layer_mm) / 0.05;
    const testing::Solid ball(grid, [&](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
      return std::hypot(c + 0.5 - 120, r + 0.5 - 121.3, (k + 0.5) * tall - 110.7) < 95;
    });
    const TrueSurface surface = surface_samples(ball.rrep);
    EXPECT_EQ(surface.name, "r-rep");
    EXPECT_NEAR(static_cast<double>(surface.points.size()), 12'000, 1'200);
    double squares = 0, mean = 0, turned = 0;
    std::array<double, 8> octants = {};
    for (const OrientedPoint& p : surface.points) {
      const Vec3f from = p.at - Vec3f(6, 6.065F, 5.535F);
      const double off = 1000 * (static_cast<double>(from.norm()) - 4.75);
      mean += off / static_cast<double>(surface.points.size());
      squares += off * off / static_cast<double>(surface.points.size());
      turned = std::max(turned, 1 - static_cast<double>(from.normalized().dot(p.normal)));
      ++octants[static_cast<std::size_t>((from[0] > 0 ? 1 : 0) + (from[1] > 0 ? 2 : 0) + (from[2] > 0 ? 4 : 0))];
    }
    EXPECT_NEAR(mean, 0, 3);
    EXPECT_LT(std::sqrt(squares), 3.5 * tall) << "um";
    EXPECT_LT(turned, 0.03 * tall * tall) << "1 - cosine";
    for (const double octant : octants) EXPECT_NEAR(octant / static_cast<double>(surface.points.size()), 0.125, 0.015);
  }
}

TEST(TrueSurface, OfAThinWallHasItsTwoSidesAndItsTop) {
  // A wall of three pixels on the plate, up to the top of the last layer.
  const PrintGrid grid = testing::cubic_grid(80, 60, 0.05F);
  const testing::Solid wall(grid, testing::blocks({{30, 33, 5, 75, 0, 60}}));
  double left = 0, right = 0, top = 0;
  for (const OrientedPoint& p : surface_samples(wall.rrep).points) {
    left += p.normal[0] < -0.99F && std::abs(p.at[0] - 1.5F) < 1e-3F ? 1 : 0;
    right += p.normal[0] > 0.99F && std::abs(p.at[0] - 1.65F) < 1e-3F ? 1 : 0;
    top += p.at[2] > 2.9F ? 1 : 0;
  }
  EXPECT_GT(left, 2500);
  EXPECT_NEAR(right / left, 1, 0.05);
  EXPECT_GT(top, 30);
}

TEST(TrueSurface, IsLeftOutBesideSupportsAndBelowThePlate) {
  const PrintGrid grid = testing::cubic_grid(100, 100, 0.1F);
  const std::vector<Strut> struts = {
      {.column0 = 50, .row0 = 50, .column1 = 50, .row1 = 50, .first = 0, .end = 40, .radius0 = 1000, .radius1 = 1000},
      {.column0 = 20,
       .row0 = 20,
       .column1 = 20,
       .row1 = 80,
       .first = 60,
       .end = 65,
       .radius0 = 300,
       .radius1 = 300,
       .lies = 1}};
  Supports supports;
  supports.list = struts;
  const float x = grid.x_of(50), y = grid.y_of(50);
  std::vector<OrientedPoint> points;
  const auto add = [&](float px, float py, float pz) { points.push_back({{px, py, pz}, {0, 0, 1}}); };
  add(x + 1.4F, y, 2);          // beside the pillar
  add(x, y, 4.4F);              // above it
  add(grid.x_of(20), y, 6.9F);  // above the middle of the lying one
  add(1, 1, -0.2F);             // below the plate
  leave_out_supports(supports, grid, points);
  EXPECT_TRUE(points.empty());
  add(x + 1.6F, y, 2);
  add(x, y, 4.6F);
  add(grid.x_of(20) + 0.9F, y, 6.2F);
  add(grid.x_of(20), grid.y_of(80) + 0.9F, 6.2F);
  add(1, 1, 0);
  leave_out_supports(supports, grid, points);
  EXPECT_EQ(points.size(), 5U);
}

}  // namespace
}  // namespace plumbline::firmware
