#include <gtest/gtest.h>

#include "slicer/core/numbers/mix64.hpp"
#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/splat_files.hpp"

namespace plumbline::testing {
namespace {

constexpr double kSplatBallRadius = 10;

/// A ball of flat splats that face either side, and a fifth of them floaters that hardly show, in the air around it.
std::vector<Splat> ball_with_floaters() {
  std::vector<Splat> splats;
  std::uint64_t state = 1;
  const auto random = [&state](double low, double high) {
    return low + (high - low) * static_cast<double>(mix64(state += kGoldenStep64) >> 11U) * 0x1p-53;
  };
  for (const SurfacePoint& p : sphere(24'000, kSplatBallRadius, {0, 0, 0})) {
    const Vec3d n = (random(0, 1) < 0.5 && p.normal[2] < 0.9) || p.normal[2] < -0.9 ? Vec3d(-p.normal) : p.normal;
    splats.push_back({p.position, random(0.5, 1), {0.12, 0.15, 0.01}, turn_from_z(n)});
  }
  for (int i = 0; i < 6'000; ++i) {
    const Vec3d at(random(-20, 20), random(-20, 20), random(-20, 20));
    splats.push_back({at, random(0.005, 0.25), {0.2, 0.3, 0.2}, {1, 0, 0, 0}});
  }
  return splats;
}

/// Splats of which two thirds are turned at random.
std::vector<Splat> box_of_turned_splats(double half) {
  std::vector<Splat> splats;
  std::uint64_t state = 7;
  const auto random = [&state] { return static_cast<double>(mix64(state += kGoldenStep64) >> 11U) * 0x1p-52 - 1; };
  Random jitter(7);
  for (const SurfacePoint& p : box({-half, -half, -half}, {half, half, half}, 0.35, 0.3, jitter)) {
    const double x = random(), y = random(), z = random();
    const Vec3d n = random() < 1.0 / 3 ? Vec3d(x, y, z).normalized() : p.normal;
    splats.push_back({p.position, 0.9, {0.2, 0.2, 0.01}, turn_from_z(n[2] < 0 ? Vec3d(-n) : n)});
  }
  return splats;
}

void expect_ball(const std::string& bytes, const char* name) {
  const Slicing sliced(MemorySource(bytes, name), settings_with_pitch(0.2F), 64 * kMiB);
  EXPECT_EQ(sliced.report().scan.left_out, 6'000U) << name;
  EXPECT_EQ(sliced.report().scan.without_normal, 0U) << name;
  const double volume = 4.0 / 3 * 3.14159265358979 * kSplatBallRadius * kSplatBallRadius * kSplatBallRadius;
  EXPECT_NEAR(sliced.volume() / volume, 1, 0.02) << name;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sliced.report().placement.size_mm[axis], 2 * kSplatBallRadius, 0.02 * 2 * kSplatBallRadius) << name;
  }
}

TEST(Splats, ABallWithTransparentFloatersKeepsItsSize) {
  const auto splats = ball_with_floaters();
  expect_ball(splat_ply(splats), "ball.ply");
  expect_ball(gzip(plain_spz(splats, 3)), "ball.spz");
}

TEST(Splats, ABoxIsThereEvenIfMostSplatsAreTurned) {
  const Slicing sliced(MemorySource(splat_ply(box_of_turned_splats(10)), "box.ply"), settings_with_pitch(0.2F),
                       64 * kMiB);
  EXPECT_GT(sliced.report().normals.estimated, sliced.report().scan.points / 3);
  EXPECT_NEAR(sliced.volume() / 8000, 1, 0.01);
}

}  // namespace
}  // namespace plumbline::testing
