#include "slicer/normals/flipped_normals.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kSpacing = 0.2;  ///< mm

Surface ball(double radius, const Vec3d& centre = Vec3d::Zero()) {
  return sphere(sphere_points(radius, kSpacing), radius, centre);
}

/// Turns over the normals of all points for which `where` is true.
/// @returns how many
std::uint32_t turn(Surface& surface, const std::function<bool(const Vec3d&)>& where) {
  std::uint32_t turned = 0;
  for (SurfacePoint& p : surface) {
    if (!where(p.position)) continue;
    p.normal = -p.normal;
    ++turned;
  }
  return turned;
}

Slicing sliced(const Surface& surface) { return Slicing(binary_ply(surface), settings_with_pitch(0.2F), 64 * kMiB); }

TEST(FlippedNormals, OfASheetAreTurnedAndTheObjectIsWhole) {
  const Surface right = ball(10);
  Surface scan = right;
  const std::uint32_t wrong = turn(scan, [](const Vec3d& p) { return p[0] > 8; });
  ASSERT_GT(wrong, 1000U);
  const Slicing with = sliced(scan);
  EXPECT_NEAR(with.report().normals.turned, wrong, 0.02 * wrong) << "some were averaged";
  EXPECT_NEAR(with.volume(), sliced(right).volume(), 0.5);
}

TEST(FlippedNormals, AreTurnedOneByOneToo) {
  Surface scan = ball(10);
  Random random(3);
  const std::uint32_t wrong = turn(scan, [&](const Vec3d&) { return random.uniform(0, 1) < 0.05; });
  const Slicing slicing = sliced(scan);
  EXPECT_NEAR(slicing.report().normals.turned, wrong, 0.05 * wrong);
  EXPECT_NEAR(slicing.volume(), 4.0 / 3 * kPi * 1000, 10);
}

TEST(FlippedNormals, AreOnlyThoseThatContradictOthers) {
  Surface apart = ball(10);
  append(apart, ball(4, {20, 0, 0}));
  EXPECT_EQ(sliced(apart).report().normals.turned, 0U);

  Surface hollow = ball(10);
  Surface inside = ball(7);
  turn(inside, [](const Vec3d&) { return true; });
  append(hollow, inside);
  EXPECT_EQ(sliced(hollow).report().normals.turned, 0U) << "the wall of a cavity faces into it";

  Random random(1);
  Surface plate = box({0, 0, 0}, {20, 20, 0.6}, kSpacing, 0.3, random);
  EXPECT_EQ(sliced(plate).report().normals.turned, 0U) << "both sides of a thin wall are right";
}

// Its points are farther from their neighbours on the same side than from those on the other.
TEST(FlippedNormals, OfAFoilDoNotContradictEachOther) {
  Random random(1);
  EXPECT_FALSE(sliced(box({0, 0, 0}, {20, 20, 0.05}, kSpacing, 0.4, random)).report().normals.contradictory);
}

// Few views saw the middle of the wall inside: its points are apart, and those of the wall outside are nearer to each of them. Their
// normals stay, though they make no sheet, and are not mistaken for those of points beside one.
TEST(FlippedNormals, OfAWallInsideATubeThatFewViewsSawAreRight) {
  constexpr double kOuter = 6;
  constexpr double kInner = 5.4;
  constexpr double kLength = 24;
  const auto rings = [](double radius, double side, double low, double high, double spacing) {
    Surface wall;
    Random random(5);
    const auto around = std::floor(2 * kPi * radius / spacing);
    for (double z = low + 0.5 * spacing; z < high; z += spacing) {
      for (double k = 0; k < around; ++k) {
        const double angle = 2 * kPi * (k + random.uniform(0, 1)) / around;
        const Vec3d out(std::cos(angle), std::sin(angle), 0);
        wall.push_back({radius * out + Vec3d(0, 0, z + spacing * random.uniform(-0.5, 0.5)), side * out});
      }
    }
    return wall;
  };
  Surface tube = rings(kOuter, 1, 0, kLength, kSpacing);
  append(tube, rings(kInner, -1, 0, 5, kSpacing));
  append(tube, rings(kInner, -1, 5, kLength - 5, 0.8));
  append(tube, rings(kInner, -1, kLength - 5, kLength, kSpacing));
  for (double radius = kInner + 0.1; radius < kOuter; radius += kSpacing) {
    for (double angle = 0; angle < 2 * kPi; angle += kSpacing / radius) {
      const Vec3d at(radius * std::cos(angle), radius * std::sin(angle), 0);
      tube.push_back({at, {0, 0, -1}});
      tube.push_back({at + Vec3d(0, 0, kLength), {0, 0, 1}});
    }
  }
  const Slicing slicing = sliced(tube);
  EXPECT_EQ(slicing.report().normals.turned, 0U);
  const double volume = kPi * (kOuter * kOuter - kInner * kInner) * kLength;
  EXPECT_NEAR(slicing.volume(), volume, 0.03 * volume);
}

// The plate is the largest sheet. By its field alone, the block's lid seems to face the wrong way.
TEST(FlippedNormals, OfABlockOnAPlateAreRight) {
  Random random(1);
  Surface scan = box({-6, -6, 0}, {6, 6, 25}, kSpacing, 0.3, random);
  append(scan, sheet({-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, kSpacing, 0.3, random));
  // No points on edges, where they could join the lid to a wall, and none below the block.
  std::erase_if(scan, [](const SurfacePoint& p) {
    const auto beside = [](double x, double edge) { return std::abs(std::abs(x) - edge) < 0.1 ? 1 : 0; };
    const Vec3d& at = p.position;
    return beside(at[0], 6) + beside(at[1], 6) + beside(at[2], 25) > 1 ||
           (at[2] == 0 && at.head<2>().cwiseAbs().maxCoeff() < 6.1);
  });
  const auto turned = [](const Surface& surface) { return sliced(surface).report().normals.turned; };
  EXPECT_EQ(turned(scan), 0U);
  const std::uint32_t lid = turn(scan, [](const Vec3d& p) { return p[2] == 25; });
  EXPECT_NEAR(turned(scan), lid, 0.02 * lid);
}

// Nobody saw the underside, nor where the inner wall meets the floor: the floor would close the outer wall if it faced down.
TEST(FlippedNormals, OfAFloorThatContradictsNoNeighbourAreRight) {
  constexpr double kStep = 0.3;   // mm, between points
  constexpr double kHeight = 30;  // mm, of the vase
  constexpr double kOuter = 10;   // mm, radius
  constexpr double kInner = 9;    // mm, radius
  constexpr double kFloor = 1.5;  // mm, height
  Surface vase;
  const auto add_ring = [&](double radius, double z, const std::function<Vec3d(double, double)>& normal) {
    const auto points = static_cast<int>(2 * kPi * radius / kStep) + 1;
    for (int i = 0; i < points; ++i) {
      const double angle = 2 * kPi * i / points;
      const Vec3d p{radius * std::cos(angle), radius * std::sin(angle), z};
      vase.push_back({p, normal(std::cos(angle), std::sin(angle))});
    }
  };
  const auto up = [](double, double) { return Vec3d{0, 0, 1}; };
  for (double z = 0; z < kHeight; z += kStep) add_ring(kOuter, z, [](double x, double y) { return Vec3d{x, y, 0}; });
  for (double z = 4; z < kHeight; z += kStep) add_ring(kInner, z, [](double x, double y) { return Vec3d{-x, -y, 0}; });
  for (double radius = kInner; radius < kOuter; radius += kStep) add_ring(radius, kHeight, up);
  for (double radius = 0; radius < kInner - 0.5; radius += kStep) add_ring(radius, kFloor, up);
  const Slicing slicing = sliced(vase);
  EXPECT_EQ(slicing.report().normals.turned, 0U);
  const double right = kPi * (kOuter * kOuter * kHeight - kInner * kInner * (kHeight - kFloor));
  EXPECT_NEAR(slicing.volume(), right, 0.05 * right);
}

TEST(FlippedNormals, OfAValleyAreRight) {
  Surface valley = ball(10);
  turn(valley, [](const Vec3d&) { return true; });
  std::erase_if(valley, [](const SurfacePoint& p) { return p.position[2] > -1; });
  EXPECT_EQ(sliced(valley).report().normals.turned, 0U);
}

TEST(FlippedNormals, OfTwoBallsInsideOutAreAllTurned) {
  Surface apart = ball(8);
  append(apart, ball(8, {20, 0, 0}));
  const double right = sliced(apart).volume();
  const std::uint32_t all = turn(apart, [](const Vec3d&) { return true; });
  const Slicing slicing = sliced(apart);
  EXPECT_TRUE(slicing.report().normals.inside_out);
  EXPECT_EQ(slicing.report().normals.turned, all - slicing.report().averaged_points);
  EXPECT_NEAR(slicing.volume(), right, 0.5);
}

TEST(FlippedNormals, AreTheSameForAnyNumberOfThreads) {
  Random random(4);
  for (const double share : {0.0, 0.5, 1.0}) {
    Surface scan = ball(10);
    turn(scan, [&](const Vec3d& p) { return p[2] > 7 || random.uniform() < share; });
    SliceSettings settings = settings_with_pitch(0.2F);
    const Slicing one(binary_ply(scan), settings, 64 * kMiB);
    settings.threads = 3;
    const Slicing three(binary_ply(scan), settings, 64 * kMiB);
    EXPECT_GT(one.report().normals.turned, 0U);
    EXPECT_EQ(three.report().normals.turned, one.report().normals.turned);
    EXPECT_EQ(three.report().normals.inside_out, share == 1);
    EXPECT_EQ(three.report().normals.contradictory, share == 0.5);
    EXPECT_TRUE(std::ranges::equal(three.rrep().packed, one.rrep().packed));
  }
}

}  // namespace
}  // namespace plumbline
