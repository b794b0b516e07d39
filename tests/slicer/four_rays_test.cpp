/// Four rays a pixel, from a scan and from a mesh.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/slicer/mesh/sliced_mesh.hpp"

namespace plumbline {
namespace {

using namespace testing;

SliceSettings with_four_rays(float pitch_mm) {
  SliceSettings settings = settings_with_pitch(pitch_mm);
  settings.grey = Grey::kFull;
  return settings;
}

/// Root mean square of how far crossings are from a sphere about the origin, in pixels: off the ray for steep ones. It visits all rays.
double off_sphere(const Slicing& sliced, const RRep& rrep, double radius) {
  const PrintGrid& grid = rrep.grid;
  const CrossingPacking packing(grid);
  const Placement& p = sliced.report().placement;
  double sum = 0;
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) {
      const std::uint32_t pixel = packing.pixel(rrep.packed[i]);
      const Vec3d print(static_cast<double>(grid.x_of(pixel % grid.columns)),
                        static_cast<double>(grid.y_of(pixel / grid.columns)),
                        static_cast<double>(packing.height_mm(rrep.packed[i], k, grid)));
      const double off = ((print - p.shift) / p.scale).norm() - radius;
      sum += off * off;
    }
  }
  return std::sqrt(sum / static_cast<double>(rrep.crossings())) / static_cast<double>(grid.pitch_x_mm);
}

TEST(FourRays, OfAScanEachMeetsTheSurface) {
  const std::string scan = binary_ply(sphere(100000, 10, {0, 0, 0}));
  const Slicing sliced(scan, with_four_rays(0.1F), 64 * kMiB);
  EXPECT_LT(off_sphere(sliced, sliced.rrep(), 10), 0.02);
  ASSERT_EQ(sliced.rrep().other_rays().size(), 4U);
  for (const RRep& other : sliced.rrep().other_rays()) {
    EXPECT_EQ(other.grid.layers, sliced.grid().layers);
    EXPECT_EQ(other.first.size(), sliced.grid().layers + 1U);
    EXPECT_LT(off_sphere(sliced, other, 10), 0.02);
    EXPECT_NEAR(static_cast<double>(other.crossings()), static_cast<double>(sliced.rrep().crossings()), 400);
  }
  SliceSettings one = settings_with_pitch(0.1F);
  EXPECT_EQ(Slicing(scan, one, 64 * kMiB).rrep().other_rays().size(), 0U);
}

TEST(FourRays, AreTheSameForAnyNumberOfThreads) {
  Random random(5);
  Surface surface = sphere(20000, 6, {0, 0, 0});
  std::erase_if(surface, [](const SurfacePoint& p) { return (p.position - Vec3d(6, 0, 1)).norm() < 1.5; });
  add_noise(surface, 0.02, 0.1, random);
  const std::string scan = binary_ply(surface);
  SliceSettings settings = with_four_rays(0.1F);
  const Slicing one(scan, settings, 64 * kMiB);
  settings.threads = 3;
  const Slicing three(scan, settings, 64 * kMiB);
  EXPECT_TRUE(std::ranges::equal(one.rrep().packed, three.rrep().packed));
  for (std::size_t i = 0; i < kRaysAround; ++i) {
    EXPECT_TRUE(std::ranges::equal(one.rrep().others[i].first, three.rrep().others[i].first)) << i;
    EXPECT_TRUE(std::ranges::equal(one.rrep().others[i].packed, three.rrep().others[i].packed)) << i;
  }
}

TEST(FourRays, OfAMeshAreWhereTheyAreMeantToBe) {
  // The grid is centred on the mesh: both walls of each axis lie at the same parts of a pixel.
  const Slicing box = sliced(box_mesh({0, 0, 0}, {2.05, 3.025, 1}), with_four_rays(0.1F));
  const Placement& p = box.report().placement;
  const auto expected = [&](const RRep& rrep) {
    std::uint64_t inside = 0;
    for (std::uint32_t r = 0; r < rrep.grid.rows; ++r) {
      for (std::uint32_t c = 0; c < rrep.grid.columns; ++c) {
        const double x = static_cast<double>(rrep.grid.x_of(c)) - p.shift[0];
        const double y = static_cast<double>(rrep.grid.y_of(r)) - p.shift[1];
        inside += x > 0 && x < 2.05 && y > 0 && y < 3.025 ? 1 : 0;
      }
    }
    return inside;
  };
  ASSERT_EQ(box.rrep().other_rays().size(), 4U);
  const auto entered = [](const RRep& rrep) { return rrep.first[1] - rrep.first[0]; };
  EXPECT_EQ(entered(box.rrep()), expected(box.rrep()));
  for (const RRep& other : box.rrep().other_rays()) EXPECT_EQ(entered(other), expected(other));
}

TEST(FourRays, AreRefusedBeforeTheyAreShotIfTheyDoNotFit) {
  const std::string scan = binary_ply(sphere(20000, 20, {0, 0, 0})), ball = binary_stl(ball_mesh({0, 0, 0}, 20, 4));
  for (const bool mesh : {false, true}) {
    SliceSettings settings = settings_with_pitch(0.05F);
    const auto sliced = [&](std::size_t bytes) {
      ArenaBlock arena(bytes);
      SliceReport report;
      MemorySource source(mesh ? ball : scan, mesh ? "ball.stl" : "ball.ply");
      const auto rrep = slice(source, settings, *arena, nullptr, report);
      if (!rrep) {
        EXPECT_EQ(rrep.error().code(), ErrorCode::kOutOfMemory) << rrep.error().message();
        EXPECT_EQ(report.peak(Stage::kRays), 0U) << "before a ray is shot";
      }
      return rrep.has_value();
    };
    EXPECT_TRUE(sliced(16 * kMiB)) << mesh;
    settings.grey = Grey::kFull;
    EXPECT_FALSE(sliced(16 * kMiB)) << mesh;
    EXPECT_TRUE(sliced(40 * kMiB)) << mesh;
  }
}

}  // namespace
}  // namespace plumbline
