/// Scans of outliers alone, and of outliers around a surface.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace outliers_test {

using namespace testing;
using ::testing::HasSubstr;

constexpr double kSide = 20;

Surface outliers(std::uint32_t points) {
  Random random(5);
  Surface surface;
  for (std::uint32_t i = 0; i < points; ++i) {
    const Vec3d place(random.uniform(0, kSide), random.uniform(0, kSide), random.uniform(0, kSide));
    surface.push_back({place, random.vector().normalized()});
  }
  return surface;
}

class LastStage final : public ProgressSink {
 public:
  void begin(Stage stage) override { last_ = stage; }
  bool advance(Stage /*stage*/, double /*fraction*/) override { return true; }
  void end(Stage /*stage*/, std::size_t /*peak_bytes*/) override {}
  std::optional<Stage> last() const { return last_; }

 private:
  std::optional<Stage> last_;
};

void expect_no_surface_before_any_ray(const Surface& surface) {
  ArenaBlock arena(64 * kMiB);
  const std::string scan = binary_ply(surface);
  MemorySource source(scan, "outliers.ply");
  SliceReport report;
  LastStage stage;
  const auto rrep = slice(source, settings_with_pitch(0.05F), *arena, &stage, report);
  ASSERT_FALSE(rrep.has_value());
  EXPECT_EQ(rrep.error().code(), ErrorCode::kNoSurface) << rrep.error().message();
  EXPECT_THAT(rrep.error().message(), HasSubstr("outliers.ply"));
  EXPECT_EQ(stage.last(), Stage::kClustering);
  EXPECT_EQ(arena->used(), 0U);
}

// The mean height over random neighbours is near 0, so the rescue of sparse surface once took outliers for a surface.
// Rays through half of the cloud then took minutes and the whole arena.
TEST(Outliers, AreNoSurface) {
  for (const std::uint32_t points : {700U, 1500U, 6000U}) expect_no_surface_before_any_ray(outliers(points));
}

TEST(Outliers, WithoutNormalsAreNoSurface) {
  for (const std::uint32_t points : {1500U, 6000U}) {
    Surface surface = outliers(points);
    for (SurfacePoint& p : surface) p.normal.setZero();
    expect_no_surface_before_any_ray(surface);
  }
}

TEST(Outliers, AreToldFromASurfaceOfFewPoints) {
  for (const std::uint32_t points : {400U, 1500U}) {
    const Slicing sliced(binary_ply(sphere(points, 10, {0, 0, 0})), settings_with_pitch(0.2F), 64 * kMiB);
    EXPECT_TRUE(sliced.report().clustering.coherent);
    EXPECT_NEAR(sliced.volume(), 4.0 / 3 * kPi * 1000, 0.03 * 4.0 / 3 * kPi * 1000) << points;
  }
}

TEST(Outliers, DontHideASurfaceOfFewerPoints) {
  Surface surface = outliers(6000);
  append(surface, sphere(2500, 7, {10, 10, 10}));
  Random random(6);
  shuffle(surface, random);
  const Slicing sliced(binary_ply(surface), settings_with_pitch(0.2F), 64 * kMiB);
  EXPECT_FALSE(sliced.report().clustering.coherent);
  EXPECT_NEAR(sliced.volume(), 4.0 / 3 * kPi * 343, 0.05 * 4.0 / 3 * kPi * 343);
}

}  // namespace outliers_test
}  // namespace plumbline
