#include "slicer/rrep/rrep.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/slicer/mesh/sliced_mesh.hpp"
#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(CrossingPacking, KeepsThePixelAndAsMuchOfTheHeightAsThereIsRoomFor) {
  struct Panel {
    std::uint32_t columns, rows, parts;
  };
  for (const auto& [columns, rows, parts] : {Panel{1, 1, 256}, Panel{2560, 1440, 256}, Panel{3840, 2400, 256},
                                             Panel{7680, 4320, 128}, Panel{16384, 16384, 16}}) {
    const PrintGrid grid{.columns = columns, .rows = rows, .layers = 100, .layer_height_mm = 0.05F};
    const CrossingPacking packing(grid);
    for (const std::uint32_t pixel : {0U, columns * rows / 2, columns * rows - 1}) {
      for (std::uint32_t part = 0; part < 256; ++part) {
        const std::uint32_t packed = packing.packed(pixel, part);
        EXPECT_EQ(packing.pixel(packed), pixel);
        const float height = (7 - 0.5F + (static_cast<float>(part) + 0.5F) / 256) * 0.05F;
        EXPECT_NEAR(packing.height_mm(packed, 7, grid), height, 0.5 * 0.05 / parts) << columns;
      }
    }
    EXPECT_NEAR(packing.height_mm(packing.packed(0), 7, grid), 7 * 0.05, 0.51 * 0.05 / parts) << "the underside";
  }
}

TEST(CrossingHeight, IsOfTheFirstLayerWhoseSamplingHeightIsNotBelowIt) {
  const PrintGrid grid{.columns = 8, .rows = 8, .layers = 20, .layer_height_mm = 0.25F};
  const auto expect = [&](float depth, std::uint32_t layer, std::uint32_t part) {
    const CrossingHeight height = height_of(depth, grid);
    EXPECT_EQ(height.layer(), layer) << depth;
    EXPECT_EQ(height.part(), part) << depth;
  };
  expect(-1, 0, 0);
  expect(0, 0, 127);
  expect(0.125F, 0, 255);
  expect(0.125F + 1.0F / 4096, 1, 0);
  expect(1.25F, 5, 127);
  expect(1.3125F, 5, 191);
  EXPECT_EQ(height_of(5.5F, grid).layer(), 20U);
}

/// Largest distance along the rays, mm, between crossings and a surface where it is less steep than 60 degrees.
/// @param height  mm, of the surface at (x, y) in scan coordinates that is nearest to z; NaN: steeper, or none
template <class Height>
double worst_height(const Slicing& sliced, Height height) {
  const RRep& rrep = sliced.rrep();
  const CrossingPacking packing(rrep.grid);
  double worst = 0;
  std::uint32_t compared = 0;
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) {
      const std::uint32_t pixel = packing.pixel(rrep.packed[i]);
      const Vec3d in_print(static_cast<double>(rrep.grid.x_of(pixel % rrep.grid.columns)),
                           static_cast<double>(rrep.grid.y_of(pixel / rrep.grid.columns)),
                           static_cast<double>(packing.height_mm(rrep.packed[i], k, rrep.grid)));
      const Vec3d p = in_print - sliced.report().placement.shift;
      const double expected = height(p);
      if (std::isnan(expected)) continue;
      worst = std::max(worst, std::abs(expected - p[2]));
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000U);
  return worst;
}

double on_ball(const Vec3d& p, double radius) {
  const double squared = radius * radius - p[0] * p[0] - p[1] * p[1];
  if (squared < radius * radius / 4) return std::nan("");
  return p[2] < 0 ? -std::sqrt(squared) : std::sqrt(squared);
}

TEST(RRep, OfAMeshHasTheHeightsOfItsTriangles) {
  // Between the planes z = x / 4 and z = 8.
  TestMesh wedge = box_mesh({-4, -4, 0}, {4, 4, 8});
  for (Vec3d& vertex : wedge.vertices) {
    if (vertex[2] < 4) vertex[2] = vertex[0] / 4;
  }
  const Slicing sliced_wedge = sliced(wedge, settings_with_pitch(0.2F));
  const double worst = worst_height(sliced_wedge, [](const Vec3d& p) { return p[2] > 4 ? 8 : p[0] / 4; });
  EXPECT_LT(worst, 0.51 * 0.2 / CrossingHeight::kParts);
  const Slicing ball = sliced(ball_mesh({0, 0, 0}, 6, 6), settings_with_pitch(0.1F));
  EXPECT_LT(worst_height(ball, [](const Vec3d& p) { return on_ball(p, 6); }), 0.004);  // flat triangles lie inside
}

TEST(RRep, OfAScanHasTheHeightsOfItsSurface) {
  const Slicing ball(binary_ply(sphere(200000, 20, {0, 0, 0})), settings_with_pitch(0.1F), 128 * kMiB);
  EXPECT_LT(worst_height(ball, [](const Vec3d& p) { return on_ball(p, 20); }), 0.002);
}

}  // namespace
}  // namespace plumbline
