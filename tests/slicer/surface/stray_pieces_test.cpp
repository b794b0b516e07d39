#include "slicer/surface/stray_pieces.hpp"

#include <gtest/gtest.h>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace stray_pieces_test {

using namespace testing;

constexpr double kSpacing = 0.2;  ///< mm; so dense that small balls are larger than small features

Surface ball(double radius, const Vec3d& centre) { return sphere(sphere_points(radius, kSpacing), radius, centre); }

Slicing sliced(const Surface& surface, bool keep_all = false, float pitch_mm = 0.4F) {
  SliceSettings settings = settings_with_pitch(pitch_mm);
  settings.keep_all = keep_all;
  return Slicing(binary_ply(surface), settings, 64 * kMiB);
}

TEST(StrayPieces, AreLeftOutBeforeTheObjectIsPlaced) {
  const Surface object = ball(20, {0, 0, 0});
  Surface scan = object;
  append(scan, ball(2.3, {60, 10, -40}));
  const Slicing without = sliced(scan);
  EXPECT_EQ(without.report().strays.pieces, 1U);
  EXPECT_NEAR(without.report().strays.points, static_cast<double>(scan.size() - object.size()), 300)
      << "some were averaged";
  EXPECT_NEAR(without.report().strays.share, 0.014, 0.004);
  EXPECT_EQ(without.report().components.solids, 1U);
  EXPECT_NEAR(without.report().placement.size_mm[2], 40, 0.1) << "the object stands on the plate, not the stray piece";
  EXPECT_NEAR(without.volume(), 4.0 / 3 * kPi * 8000, 100);
  const Slicing with = sliced(scan, true);
  EXPECT_EQ(with.report().strays.pieces, 0U);
  EXPECT_EQ(with.report().components.solids, 2U);
  EXPECT_NEAR(with.report().placement.size_mm[2], 62.3, 0.1);
}

TEST(StrayPieces, DontIncludeOneOfTwoLegs) {
  Random random(1);
  Surface scan = box({0, 0, 0}, {3, 3, 20}, kSpacing, 0.3, random);
  append(scan, box({40, 0, 0}, {43, 3, 20}, kSpacing, 0.3, random));
  EXPECT_EQ(sliced(scan).report().strays.pieces, 0U);
}

TEST(StrayPieces, DontIncludeManySmallPieces) {
  Surface scan = ball(20, {0, 0, 0});
  for (int i = 0; i < 8; ++i) {
    append(scan, ball(2.75, {45 * std::cos(i * kPi / 4), 45 * std::sin(i * kPi / 4), 0}));
  }
  const Slicing slicing = sliced(scan);
  EXPECT_EQ(slicing.report().strays.pieces, 0U);
  EXPECT_EQ(slicing.report().components.solids, 9U);
}

TEST(StrayPieces, DontIncludePiecesThatTouchTheObjectOrLieInAHole) {
  Surface close = ball(10, {0, 0, 0});
  append(close, ball(1, {0, 0, 11.5}));
  EXPECT_EQ(sliced(close).report().strays.pieces, 0U);

  // A scanner sees the bottom of a deep hole through its mouth, but not the walls between.
  Surface hole;
  for (const SurfacePoint& p : ball(10, {0, 0, 0})) {
    if (std::abs(p.position[0]) > 5 || std::abs(p.position[1]) > 5 || p.position[2] < 0) hole.push_back(p);
  }
  for (double x = -1; x <= 1; x += kSpacing) {
    for (double y = -1; y <= 1; y += kSpacing) hole.push_back({{x, y, 7}, {0, 0, 1}});
  }
  EXPECT_EQ(sliced(hole).report().strays.pieces, 0U);
}

TEST(StrayPieces, IncludeAPieceInTheAirInsideARing) {
  Surface scan = torus(20, 3, {0, 0, 0}, kSpacing, 2);
  append(scan, ball(1.6, {0, 0, 0}));
  EXPECT_EQ(sliced(scan).report().strays.pieces, 1U);
  EXPECT_EQ(sliced(scan, true).report().strays.pieces, 0U);
}

TEST(StrayPieces, AreFoundAsFloatingSolidWhereCellsJoinThemToTheObject) {
  // The stray piece is so close that cells join it to the object, but its solid is still separate.
  constexpr double kDense = 0.1;
  Surface scan = sphere(sphere_points(10, kDense), 10, {0, 0, 0});
  append(scan, sphere(sphere_points(1.12, kDense), 1.12, {0, 0, 11.62}));
  const Slicing without = sliced(scan, false, 0.2F);
  EXPECT_EQ(without.report().strays.pieces, 0U);
  EXPECT_EQ(without.report().components.floating_solids, 1U);
  EXPECT_EQ(without.report().components.solids, 1U);
  const Slicing with = sliced(scan, true, 0.2F);
  EXPECT_EQ(with.report().components.floating_solids, 0U);
  EXPECT_EQ(with.report().components.solids, 2U);
}

TEST(StrayPieces, DontIncludeAPieceOnThePlate) {
  Random random(1);
  Surface scan = box({0, 0, 0}, {20, 20, 20}, kSpacing, 0.3, random);
  append(scan, box({21.5, 0, 0}, {24, 3, 3}, kSpacing, 0.3, random));
  const Slicing slicing = sliced(scan);
  EXPECT_EQ(slicing.report().components.floating_solids, 0U);
}

TEST(StrayPieces, AreAllFoundWhenOneIsFarAway) {
  Surface scan = ball(10, {0, 0, 0});
  append(scan, ball(1, {1000, 0, 0}));
  append(scan, ball(1, {0, 22, 0}));
  const Slicing slicing = sliced(scan);
  EXPECT_EQ(slicing.report().strays.pieces, 2U);
  EXPECT_NEAR(slicing.report().placement.size_mm.maxCoeff(), 20, 0.1);
}

}  // namespace stray_pieces_test
}  // namespace plumbline
