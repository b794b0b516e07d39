/// Floors that objects were scanned on, and what looks like one.

#include "slicer/placement/floor_plane.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kSpacing = 0.4;

/// What a scanner saw of a floor around something: nothing in its shadow.
Surface floor_around(double side, double shadow, Random& random) {
  Surface all = sheet({-side / 2, -side / 2, 0}, {side, 0, 0}, {0, side, 0}, kSpacing, 0.3, random);
  Surface seen;
  for (const SurfacePoint& p : all) {
    if (p.position.norm() > shadow) seen.push_back(p);
  }
  return seen;
}

/// @param shadow  radius of the floor that was not seen; 0: the whole floor was
Surface ball_on_floor(Random& random, double shadow = 5, double noise = 0.01) {
  Surface scan;
  for (const SurfacePoint& p : sphere(sphere_points(10, kSpacing), 10, {0, 0, 10})) {
    if (p.position[2] > 0.3 * shadow) scan.push_back(p);
  }
  append(scan, floor_around(60, shadow, random));
  add_noise(scan, noise, 0.01, random);
  return scan;
}

/// A disc with a wall that goes down from its edge, as a scanner above sees it.
Surface round_table(double radius, double height, double shadow, Random& random) {
  Surface table = floor_around(2 * radius, shadow, random);
  std::erase_if(table, [&](const SurfacePoint& p) { return p.position.norm() > radius; });
  for (const SurfacePoint& p :
       sheet({0, 0, -height}, {2 * kPi * radius, 0, 0}, {0, 0, height}, kSpacing, 0.3, random)) {
    const double angle = p.position[0] / radius;
    const Vec3d out(std::cos(angle), std::sin(angle), 0);
    table.push_back({radius * out + Vec3d(0, 0, p.position[2]), out});
  }
  return table;
}

Surface ball_on_turntable(double shadow, double noise, Random& random) {
  Surface scan = round_table(30, 5, shadow, random);
  for (const SurfacePoint& p : sphere(sphere_points(10, kSpacing), 10, {0, 0, 10})) {
    if (p.position[2] > 0.3 * shadow) scan.push_back(p);
  }
  add_noise(scan, noise, 0.01, random);
  return scan;
}

/// As XYZ files are: positions only.
std::string text_of(const Surface& surface) {
  std::string text;
  for (const SurfacePoint& p : surface) {
    text += std::to_string(p.position[0]) + ' ' + std::to_string(p.position[1]) + ' ' + std::to_string(p.position[2]) +
            '\n';
  }
  return text;
}

/// Rotates a scan about x, as if the floor were not level.
Surface tilted(Surface surface, double degrees) {
  const Mat3d turn = rotation_matrix({degrees, 0, 0});
  for (SurfacePoint& p : surface) p = {turn * p.position, turn * p.normal};
  return surface;
}

SliceReport report_of(const Surface& surface, FloorChoice floor = {}) {
  SliceSettings settings = settings_with_pitch(0.25F);
  settings.placement.printer = PrinterVolume{320, 320, 0.25F, 0.25F, 80};
  settings.floor = floor;
  return Slicing(binary_ply(surface), settings, 64 * kMiB).report();
}

TEST(Floor, IsCutOffBelowABall) {
  Random random(1);
  const Surface scan = ball_on_floor(random);
  const SliceReport report = report_of(scan);
  EXPECT_GT(report.floor.points, 15'000U);
  EXPECT_NEAR(report.floor.height, 0, 0.02);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(report.placement.size_mm[axis], 20, 0.25);
  const Vec3d centre = report.placement.scale * report.placement.rotation * Vec3d(0, 0, 10) + report.placement.shift;
  EXPECT_NEAR(centre[0], 40, 0.25);
  EXPECT_NEAR(centre[1], 40, 0.25);
  EXPECT_NEAR(centre[2], 10, 0.25);
}

TEST(Floor, LeavesABallOfItsVolume) {
  Random random(1);
  SliceSettings settings = settings_with_pitch(0.25F);
  const Slicing sliced(binary_ply(ball_on_floor(random)), settings, 64 * kMiB);
  // The cap that was in the shadow is closed flat, or as a foot: it has 2 % of the volume.
  EXPECT_NEAR(sliced.volume(), 4.0 / 3 * kPi * 1000, 0.04 * 4189);
}

TEST(Floor, IsLevelledIfItIsTilted) {
  Random random(2);
  const SliceReport report = report_of(tilted(ball_on_floor(random), 4));
  EXPECT_NEAR(static_cast<double>(report.floor.tilt), std::sin(4 * kPi / 180), 0.002);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(report.placement.size_mm[axis], 20, 0.25);
  const Vec3d up = report.placement.rotation * (rotation_matrix({4, 0, 0}) * Vec3d(0, 0, 1));
  EXPECT_NEAR(up[2], 1, 1e-5);
}

TEST(Floor, IsCutOffWithoutNormals) {
  for (const double shadow : {0.0, 5.0}) {
    for (const double degrees : {0.0, 4.0}) {
      for (const double noise : {0.01, 0.08}) {
        Random random(11);
        const Surface scan = tilted(ball_on_floor(random, shadow, noise), degrees);
        const Slicing sliced(MemorySource(text_of(scan), "ball.xyz"), settings_with_pitch(0.25F), 64 * kMiB);
        EXPECT_GT(sliced.report().floor.points, 15'000U) << shadow << ' ' << degrees << ' ' << noise;
        for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(sliced.report().placement.size_mm[axis], 20, 0.6);
        EXPECT_NEAR(sliced.volume(), 4.0 / 3 * kPi * 1000, 0.06 * 4189);
      }
    }
  }
}

TEST(Floor, IsCutOffWithTheRimOfATurntable) {
  for (const bool has_normals : {true, false}) {
    for (const double shadow : {0.0, 5.0}) {
      for (const double degrees : {0.0, 4.0}) {
        for (const double noise : {0.01, 0.08}) {
          Random random(14);
          const Surface scan = tilted(ball_on_turntable(shadow, noise, random), degrees);
          const std::string file = has_normals ? binary_ply(scan) : text_of(scan);
          const Slicing sliced(MemorySource(file, has_normals ? "ball.ply" : "ball.xyz"), settings_with_pitch(0.25F),
                               64 * kMiB);
          SCOPED_TRACE(::testing::Message() << has_normals << ' ' << shadow << ' ' << degrees << ' ' << noise);
          EXPECT_GT(sliced.report().floor.points, 20'000U);
          for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(sliced.report().placement.size_mm[axis], 20, 0.6);
          EXPECT_NEAR(sliced.volume(), 4.0 / 3 * kPi * 1000, 0.06 * 4189);
        }
      }
    }
  }
}

TEST(Floor, LeavesATallColumnOfItsVolumeWithoutNormals) {
  Random random(11);
  Surface scan = floor_around(80, 5, random);
  for (int ring = 0; ring < 100; ++ring) {
    for (int k = 0; k < 78; ++k) {
      const double angle = 2 * kPi * (k + 0.5 * (ring % 2)) / 78;
      const Vec3d out(std::cos(angle), std::sin(angle), 0);
      scan.push_back({5 * out + Vec3d(0, 0, 0.4 * ring), out});
    }
  }
  for (const SurfacePoint& p : sphere(sphere_points(5, kSpacing), 5, {0, 0, 40})) {
    if (p.position[2] > 40) scan.push_back(p);
  }
  add_noise(scan, 0.02, 0.01, random);
  const Slicing sliced(MemorySource(text_of(scan), "column.xyz"), settings_with_pitch(0.25F), 64 * kMiB);
  const double volume = kPi * 25 * 40 + 2.0 / 3 * kPi * 125;
  EXPECT_GT(sliced.report().floor.points, 15'000U);
  EXPECT_NEAR(sliced.volume(), volume, 0.06 * volume);
}

TEST(Floor, IsPrintedIfItIsToBeKept) {
  Random random(1);
  const SliceReport report = report_of(ball_on_floor(random), {FloorChoice::Kind::kKeep, 0});
  EXPECT_EQ(report.floor.points, 0U);
  EXPECT_NEAR(report.placement.size_mm[0], 60, 0.5);
}

TEST(Floor, IsCutAtTheHeightAskedFor) {
  Random random(3);
  Surface scan = box({-5, -5, 3}, {5, 5, 23}, kSpacing, 0.3, random);
  add_noise(scan, 0.005, 0.01, random);
  const SliceReport report = report_of(scan, {FloorChoice::Kind::kHeight, 8});
  EXPECT_NEAR(report.placement.size_mm[2], 15, 0.03);
  EXPECT_GT(report.floor.points, 1000U);
}

std::uint32_t floor_points_in(Surface surface) {
  Random random(9);
  add_noise(surface, 0.01, 0.01, random);
  return report_of(surface).floor.points;
}

TEST(Floor, IsNotTheUndersideOfABox) {
  Random random(4);
  EXPECT_EQ(floor_points_in(box({-10, -10, 0}, {10, 10, 20}, kSpacing, 0.3, random)), 0U);
}

TEST(Floor, IsNotAPlateWithLetters) {
  Random random(5);
  Surface plate = box({-20, -10, 0}, {20, 10, 2}, kSpacing, 0.3, random);
  for (int letter = 0; letter < 4; ++letter) {
    append(plate, box({-17 + 9.0 * letter, -5, 2}, {-12 + 9.0 * letter, 5, 4}, kSpacing, 0.3, random));
  }
  EXPECT_EQ(floor_points_in(plate), 0U);
}

/// As a scanner above sees it: no walls and no underside of the plate.
TEST(Floor, IsNotTheGroundOfARelief) {
  Random random(6);
  Surface relief = sheet({-20, -10, 0}, {40, 0, 0}, {0, 20, 0}, kSpacing, 0.3, random);
  append(relief, box({-12, -6, 0}, {12, 6, 2}, kSpacing, 0.3, random));
  EXPECT_EQ(floor_points_in(relief), 0U);
}

TEST(Floor, IsNotThePlinthOfAFigure) {
  Random random(7);
  Surface figure = box({-12, -12, 0}, {12, 12, 2}, kSpacing, 0.3, random);
  append(figure, box({-4, -4, 2}, {4, 4, 25}, kSpacing, 0.3, random));
  EXPECT_EQ(floor_points_in(figure), 0U);
}

/// Never seen from below, it differs from a turntable by its width only.
TEST(Floor, IsNotTheRoundPlinthOfAFigure) {
  for (const double shadow : {0.0, 4.0}) {
    Random random(15);
    Surface figure = round_table(10, 3, shadow, random);
    append(figure, box({-7, -4, 0}, {7, 4, 25}, kSpacing, 0.3, random));
    EXPECT_EQ(floor_points_in(figure), 0U);
  }
}

TEST(Floor, IsNotAWideSquarePlinthNeverSeenFromBelow) {
  Random random(16);
  Surface figure = box({-20, -20, -3}, {20, 20, 0}, kSpacing, 0.3, random);
  std::erase_if(figure, [](const SurfacePoint& p) { return p.normal[2] < -0.5; });
  append(figure, box({-6, -6, 0}, {6, 6, 25}, kSpacing, 0.3, random));
  EXPECT_EQ(floor_points_in(figure), 0U);
}

TEST(Floor, IsNotAWideRoundPlinthSeenFromBelow) {
  Random random(17);
  Surface figure = round_table(20, 3, 0, random);
  for (SurfacePoint p : floor_around(40, 0, random)) {
    if (p.position.norm() > 20) continue;
    p.position[2] = -3;
    p.normal = -p.normal;
    figure.push_back(p);
  }
  append(figure, box({-6, -6, 0}, {6, 6, 25}, kSpacing, 0.3, random));
  EXPECT_EQ(floor_points_in(figure), 0U);
}

TEST(Floor, IsNotACoinOrAWheel) {
  Random random(18);
  Surface coin = round_table(12, 2, 0, random);
  append(coin, sphere(sphere_points(4, kSpacing), 4, {2, 1, -3}));
  EXPECT_EQ(floor_points_in(coin), 0U);
  // A hub on a wheel: lower than a quarter of its width is no object on a turntable.
  Surface wheel = round_table(15, 4, 3, random);
  append(wheel, round_table(5, 1, 0, random));
  for (SurfacePoint& p : wheel) {
    if (p.position.norm() < 6) p.position[2] += 1;
  }
  EXPECT_EQ(floor_points_in(wheel), 0U);
}

TEST(Floor, IsNotTheBottomOfACup) {
  Random random(8);
  Surface cup = box({-10, -10, 0}, {10, 10, 20}, kSpacing, 0.3, random);
  std::erase_if(cup, [](const SurfacePoint& p) {
    return p.normal[2] > 0.5 && std::abs(p.position[0]) < 8 && std::abs(p.position[1]) < 8;
  });
  Surface inside = box({-8, -8, 2}, {8, 8, 20}, kSpacing, 0.3, random);
  for (SurfacePoint& p : inside) p.normal = -p.normal;
  std::erase_if(inside, [](const SurfacePoint& p) { return p.normal[2] < -0.5; });
  append(cup, inside);
  EXPECT_EQ(floor_points_in(cup), 0U);
}

TEST(Levelling, TurnsUpToZ) {
  Random random(12);
  for (int i = 0; i < 100; ++i) {
    Vec3d up = random.vector().normalized();
    if (up[2] < -0.9) up = -up;
    const Mat3d turn = levelling(up);
    EXPECT_LT((turn * up - Vec3d(0, 0, 1)).norm(), 1e-12);
    EXPECT_LT((turn * turn.transpose() - Mat3d::Identity()).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace plumbline
