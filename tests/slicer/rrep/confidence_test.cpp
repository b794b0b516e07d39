#include "slicer/rrep/confidence.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kRadius = 8;     ///< mm
constexpr double kPitch = 0.2;    ///< mm
constexpr double kCut = -5;       ///< mm: nothing was seen below
constexpr double kSpacing = 0.1;  ///< mm

Surface scan_without_underside() {
  Surface surface = sphere(sphere_points(kRadius, kSpacing), kRadius, {0, 0, 0});
  std::erase_if(surface, [](const SurfacePoint& p) { return p.position[2] < kCut; });
  return surface;
}

Slicing sliced(const Surface& surface, bool confidence = true, std::uint32_t threads = 1) {
  SliceSettings settings = settings_with_pitch(static_cast<float>(kPitch));
  settings.confidence = confidence;
  settings.threads = threads;
  return Slicing(binary_ply(surface), settings, 64 * kMiB);
}

TEST(ConfidenceMap, DistinguishesTheBasePlaneFromMeasuredSurface) {
  const Slicing slicing = sliced(scan_without_underside());
  const ConfidenceShares shares = slicing.report().confidence.shares();
  // Areas over pi of the cap (2 pi r h) and of the disc that closes it.
  const double cap = 2 * kRadius * (kRadius - kCut);
  const double disc = kRadius * kRadius - kCut * kCut;
  // Cells are an epsilon wide, and those at the rim are measured.
  EXPECT_NEAR(shares.of(Evidence::kBase), disc / (cap + disc), 0.05);
  EXPECT_NEAR(shares.of(Evidence::kMeasured), cap / (cap + disc), 0.05);
  const double rays = kPi * disc / (kPitch * kPitch);
  EXPECT_NEAR(static_cast<double>(shares.crossings[static_cast<std::size_t>(Evidence::kBase)]), rays, 0.1 * rays);
}

TEST(ConfidenceMap, CountsCrossingsByLayerAndByPlace) {
  const Slicing slicing = sliced(scan_without_underside());
  const ConfidenceMap& map = slicing.report().confidence;
  const auto base = static_cast<std::size_t>(Evidence::kBase);
  ASSERT_EQ(map.layers().size(), slicing.grid().layers);
  EXPECT_EQ(map.layers()[0][base], map.crossings()[base]) << "the base plane is below the first layer";
  const std::uint32_t column = slicing.grid().columns / 2;
  const std::uint32_t row = slicing.grid().rows / 2;
  EXPECT_EQ(map.at(column, row, 0), Evidence::kBase);
  EXPECT_EQ(map.at(column, row, slicing.grid().layers - 1), Evidence::kMeasured);
  EXPECT_EQ(map.at(0, row, static_cast<std::uint32_t>(-kCut / kPitch)), Evidence::kMeasured)
      << "a wall without crossings";
}

TEST(ConfidenceMap, FindsAHoleInTheSide) {
  Surface surface = sphere(sphere_points(kRadius, kSpacing), kRadius, {0, 0, 0});
  // The hole is a cap 1 mm high at the upper right: 2 pi r h out of 4 pi r^2.
  const Vec3d towards = Vec3d(1, 0, 1).normalized();
  std::erase_if(surface, [&](const SurfacePoint& p) { return p.position.dot(towards) > kRadius - 1; });
  const Slicing slicing = sliced(surface);
  // The surface of the rim's points covers the outer two cells of the hole, so these count as seen.
  const double hole = slicing.report().confidence.shares().of(Evidence::kWinding);
  EXPECT_GT(hole, 0.25 / (2 * kRadius));
  EXPECT_LT(hole, 1 / (2 * kRadius));
  EXPECT_LT(slicing.report().confidence.shares().of(Evidence::kBase), 0.01);
}

TEST(ConfidenceMap, ChangesNoMaskAndDoesNotDependOnThreads) {
  const Surface surface = scan_without_underside();
  const Slicing without = sliced(surface, false);
  const Slicing one = sliced(surface);
  const Slicing four = sliced(surface, true, 4);
  EXPECT_TRUE(without.report().confidence.empty());
  EXPECT_TRUE(std::ranges::equal(without.rrep().packed, one.rrep().packed));
  EXPECT_TRUE(std::ranges::equal(one.report().confidence.layers(), four.report().confidence.layers()));
  EXPECT_EQ(one.report().confidence.surface(), four.report().confidence.surface());
}

TEST(ConfidenceMap, FitsTheMemoryPlan) {
  const Slicing slicing = sliced(scan_without_underside());
  for (const Stage stage : {Stage::kRays, Stage::kRRep}) {
    const auto i = static_cast<std::size_t>(stage);
    EXPECT_LE(slicing.report().peak_bytes[i], slicing.report().planned_bytes[i]) << to_string(stage);
  }
}

}  // namespace
}  // namespace plumbline
