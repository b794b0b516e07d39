#include "slicer/ways_up.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "slicer/preparation.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/meshes.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A leg of 10 x 10 x 40 on a foot of 30 x 10 x 10.
TestMesh ell() {
  TestMesh mesh = box_mesh({0, 0, 0}, {30, 10, 10});
  append(mesh, box_mesh({0, 0, 5}, {10, 10, 40}));
  return mesh;
}
constexpr double kEllVolume = 30 * 10 * 10 + 10 * 10 * 30;

SliceSettings with_supports(const PrintSize& size) {
  SliceSettings settings = settings_with_pitch(0.25F);
  settings.placement.size = size;
  settings.supports = SupportSettings();
  return settings;
}

PrintedWays ways_of(const std::string& bytes, const SliceSettings& settings) {
  ArenaBlock arena(64 * kMiB);
  MemorySource source(bytes, "test");
  ByteSource* const one[] = {&source};
  PreparationReport report;
  PrintedWays ways;
  const auto look = [&](const PreparedScan& scan, const SurfaceSamples& samples) -> Status {
    const auto found = find_ways_up(scan.cloud, samples, settings, *arena, {});
    PLUMBLINE_TRY(found);
    ways = *found;
    return {};
  };
  const Status done = prepare_normals(one, settings, *arena, nullptr, report, look);
  EXPECT_TRUE(done) << done.error().message();
  return ways;
}

TEST(WaysUp, AreOfOneSizeAndPrintedAsTheyAreShown) {
  const SliceSettings settings = with_supports({Side::kHeight, 20});
  const std::string stl = binary_stl(ell());
  const PrintedWays ways = ways_of(stl, settings);
  for (const WayUp& way : ways) {
    SliceSettings typed = settings;
    typed.placement.rotation_degrees = {way.degrees[0], way.degrees[1], 0};
    const Slicing print(MemorySource(stl, "ell.stl"), typed, 64 * kMiB);
    EXPECT_NEAR(way.unit_mm, 0.5, 1e-3);
    EXPECT_NEAR(print.report().placement.scale, 0.5, 1e-6);
    EXPECT_NEAR(print.volume(), kEllVolume / 8, 0.01 * kEllVolume / 8) << way.degrees[0] << ", " << way.degrees[1];
    // The points that stand for a mesh end half of their distance before its edges.
    EXPECT_NEAR(way.height_mm, print.report().placement.size_mm[2], 0.02 * way.height_mm);
  }
  EXPECT_NEAR(ways[0].height_mm, 20, 1e-3);
  EXPECT_EQ(ways[0].layers, 80U) << "of 0.25 mm, on its foot";
  ASSERT_TRUE(ways[0].supports);
  EXPECT_EQ(ways[0].supports->tips, 0U) << "nothing of it hangs over";
  EXPECT_EQ(ways[0].supports->volume_mm3, 0);
}

/// A stem of radius 3 and 12 high under half a ball of radius 10.
Surface mushroom() {
  Surface surface;
  constexpr double kApart = 0.3;
  for (const SurfacePoint& p : sphere(30000, 10, {0, 0, 12})) {
    if (p.normal[2] > 0) surface.push_back(p);
  }
  const auto ring = [&](double radius, double z, const Vec3d* normal) {
    const int count = static_cast<int>(2 * kPi * radius / kApart) + 1;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * kPi * (i + z) / count;
      const Vec3d out(std::cos(angle), std::sin(angle), 0);
      surface.push_back({radius * out + Vec3d(0, 0, z), normal != nullptr ? *normal : out});
    }
  };
  const Vec3d down(0, 0, -1);
  for (double z = 0; z <= 12; z += kApart) ring(3, z, nullptr);
  for (double radius = 3 + kApart; radius < 10; radius += kApart) ring(radius, 12, &down);
  for (double radius = kApart; radius < 3; radius += kApart) ring(radius, 0, &down);
  return surface;
}

TEST(WaysUp, HaveTheSupportsOfAPrint) {
  SliceSettings settings = with_supports({Side::kHeight, 22});
  const std::string ply = binary_ply(mushroom());
  const PrintedWays ways = ways_of(ply, settings);
  ASSERT_TRUE(ways[0].supports);
  const auto& [tips, scars, clean, volume] = *ways[0].supports;
  // The underside of the cap has pi (10^2 - 3^2) mm2, of which a tip carries 12 at most.
  const double underside = std::numbers::pi * 91;
  EXPECT_GE(tips, underside / settings.supports->area_per_tip * 0.7);
  EXPECT_LE(tips, underside / settings.supports->area_per_tip * 3);
  const double thickest = std::numbers::pi / 4 * 0.6 * 0.6, thinnest = thickest / 4;  // 0.3 to 0.6 mm
  EXPECT_GE(scars, tips * thinnest);
  EXPECT_LE(scars, tips * thickest * 1.0001);
  EXPECT_EQ(clean, 0) << "no side is to stay clean";
  EXPECT_GT(volume, 10);
  EXPECT_LT(volume, std::numbers::pi * 91 * 12) << "less than all of the room below";
  settings.keep_clean = CleanSide::kMinusZ;
  const PrintedWays kept = ways_of(ply, settings);
  EXPECT_NEAR(kept[0].supports->clean_mm2, kept[0].supports->scar_mm2, 0.25 * kept[0].supports->scar_mm2);
  EXPECT_GT(kept[0].cost.total, ways[0].cost.total + 1);
  EXPECT_LT(cheapest(kept).supports->clean_mm2, 0.2 * kept[0].supports->clean_mm2);
}

TEST(WaysUp, HaveNoSupportsWhereNobodyWantsAnyOrThereIsNoRoom) {
  SliceSettings settings = with_supports({Side::kHeight, 22});
  settings.supports.reset();
  for (const WayUp& way : ways_of(binary_stl(ell()), settings)) EXPECT_FALSE(way.supports);
}

}  // namespace
}  // namespace plumbline
