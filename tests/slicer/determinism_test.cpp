/// The masks depend neither on the number of threads nor on the arena's size: the crossings are the same bit by bit.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A scan in which threads share work: noise, outliers, a hole, an open underside, walls, two bodies.
Surface awkward_scan() {
  Random random(91);
  Surface surface;
  for (const SurfacePoint& p : sphere(13000, 6, {0, 0, 4})) {
    const bool hole = (p.position - Vec3d(6, 0, 4)).norm() < 1.5;
    if (p.position[2] > 0 && !hole) surface.push_back(p);
  }
  append(surface, box({8, -3, 0}, {12, 3, 5}, 0.21, 0.4, random));
  add_noise(surface, 0.02, 0.1, random);
  for (int i = 0; i < 150; ++i) {
    surface.push_back(
        {Vec3d(random.uniform(-6, 12), random.uniform(-6, 6), random.uniform(0, 10)), random.vector().normalized()});
  }
  shuffle(surface, random);
  return surface;
}

TEST(Determinism, TheRRepIsTheSameForAnyNumberOfThreads) {
  const std::string scan = binary_ply(awkward_scan());
  SliceSettings settings;
  settings.placement.pixel_pitch_mm = 0.14F;
  settings.placement.layer_height_mm = 0.14F;
  const Slicing one(scan, settings, 64 * kMiB);
  ASSERT_GT(one.rrep().crossings(), 10000U);
  for (const std::uint32_t threads : {2U, 3U, 8U}) {
    settings.threads = threads;
    const Slicing many(scan, settings, 64 * kMiB);
    EXPECT_TRUE(std::ranges::equal(many.rrep().first, one.rrep().first)) << threads;
    EXPECT_TRUE(std::ranges::equal(many.rrep().packed, one.rrep().packed)) << threads;
    EXPECT_EQ(many.report().clustering.points, one.report().clustering.points) << threads;
    EXPECT_EQ(many.report().clustering.core_points, one.report().clustering.core_points) << threads;
    EXPECT_EQ(many.report().lengths.noise.value, one.report().lengths.noise.value) << threads;
    EXPECT_EQ(many.report().rays.decided, one.report().rays.decided) << threads;
    EXPECT_EQ(many.report().width_mm, one.report().width_mm) << threads;
  }
}

TEST(Determinism, TheRRepIsTheSameInALargerArenaIfNothingIsThinned) {
  const std::string scan = binary_ply(awkward_scan());
  SliceSettings settings;
  settings.placement.pixel_pitch_mm = 0.28F;
  settings.placement.layer_height_mm = 0.28F;
  const Slicing small(scan, settings, 24 * kMiB);
  const Slicing large(scan, settings, 200 * kMiB);
  ASSERT_EQ(small.report().cloud_points, large.report().cloud_points);
  EXPECT_TRUE(std::ranges::equal(small.rrep().first, large.rrep().first));
  EXPECT_TRUE(std::ranges::equal(small.rrep().packed, large.rrep().packed));
}

}  // namespace
}  // namespace plumbline
