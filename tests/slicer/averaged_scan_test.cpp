/// Slices scans that are noisier than their neighbourhoods are wide, as those of time-of-flight cameras are.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace averaged_scan_test {

using namespace testing;
using ::testing::HasSubstr;

constexpr double kRadius = 20;  ///< mm
constexpr double kNoise = 2;    ///< mm
constexpr double kBall = 4.0 / 3 * kPi * kRadius * kRadius * kRadius;
/// Noise in every direction puts points farther out, by kNoise^2 / kRadius in the mean: that is 3 % of the volume.
constexpr double kTolerance = 0.06 * kBall;

/// A ball whose points are off in every direction, without normals.
Surface noisy_ball(std::uint32_t points, double noise) {
  Surface surface = sphere(points, kRadius, Vec3d::Zero());
  Random random(7);
  for (SurfacePoint& p : surface) {
    p.position += noise * random.vector();
    p.normal.setZero();
  }
  shuffle(surface, random);
  return surface;
}

class AveragingsSeen final : public ProgressSink {
 public:
  void begin(Stage /*stage*/) override {}
  bool advance(Stage /*stage*/, double /*fraction*/) override { return true; }
  void end(Stage /*stage*/, std::size_t /*peak_bytes*/) override {}
  void averages(std::uint32_t points) override { points_.push_back(points); }
  const std::vector<std::uint32_t>& points() const { return points_; }

 private:
  std::vector<std::uint32_t> points_;
};

// It was refused: "no surface found".
TEST(AveragedScan, IsPrintedAndTellsHowNoisyItIs) {
  const Slicing sliced(binary_ply(noisy_ball(12'000, kNoise)), settings_with_pitch(1), 64 * kMiB);
  EXPECT_GE(sliced.report().averagings, 1U);
  EXPECT_NEAR(sliced.volume(), kBall, kTolerance);
  EXPECT_EQ(sliced.report().components.solids, 1U);
  EXPECT_NEAR(sliced.report().lengths.averaged_noise.value, kNoise, 0.4 * kNoise);
}

TEST(AveragedScan, StandsTheWayUpThatWasAskedFor) {
  SliceSettings settings = settings_with_pitch(1);
  settings.orient = true;
  const Slicing sliced(binary_ply(noisy_ball(12'000, kNoise)), settings, 64 * kMiB);
  EXPECT_GE(sliced.report().averagings, 1U);
  ASSERT_TRUE(sliced.report().turned.has_value());
  EXPECT_NEAR(sliced.volume(), kBall, kTolerance);
}

TEST(AveragedScan, ScansWithASurfaceAreNotAveraged) {
  for (const double noise : {0.0, 0.4}) {
    const Slicing sliced(binary_ply(noisy_ball(12'000, noise)), settings_with_pitch(1), 64 * kMiB);
    EXPECT_EQ(sliced.report().averagings, 0U) << noise;
    EXPECT_EQ(sliced.report().lengths.averaged_noise.value, 0) << noise;
  }
}

// Means of random points lie like a lattice, whose planes are surfaces if there are few.
TEST(AveragedScan, RandomPointsStayWithoutASurface) {
  for (const std::uint32_t points : {6500U, 9000U, 14'000U}) {
    Random random(points);
    Surface surface;
    for (std::uint32_t i = 0; i < points; ++i) {
      surface.push_back({Vec3d(random.uniform(0, 20), random.uniform(0, 20), random.uniform(0, 20)), Vec3d::Zero()});
    }
    ArenaBlock arena(64 * kMiB);
    const std::string bytes = binary_ply(surface);
    MemorySource source(bytes, "random.ply");
    SliceReport report;
    AveragingsSeen progress;
    const auto rrep = slice(source, settings_with_pitch(0.1F), *arena, &progress, report);
    ASSERT_FALSE(rrep.has_value()) << points;
    EXPECT_EQ(rrep.error().code(), ErrorCode::kNoSurface);
    EXPECT_THAT(rrep.error().message(), HasSubstr("its " + std::to_string(points) + " points fill the object"));
    ASSERT_GE(progress.points().size(), 1U);
    EXPECT_LE(progress.points().size(), 2U);
    EXPECT_EQ(report.averagings, 0U);
    EXPECT_EQ(arena->used(), 0U);
  }
}

}  // namespace averaged_scan_test
}  // namespace plumbline
