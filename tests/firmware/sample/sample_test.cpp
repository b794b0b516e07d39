#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "firmware/sample/analytic_bust.hpp"
#include "firmware/sample/counter_rng.hpp"
#include "firmware/sample/scan_sample.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

class Collector : public PointSink {
 public:
  Status begin(const ScanHeader& header) override {
    declared = header.declared_points.value_or(0);
    return {};
  }
  Status take(std::span<const ScanPoint> batch) override {
    points.insert(points.end(), batch.begin(), batch.end());
    return {};
  }
  bool progress(double fraction) override {
    EXPECT_GE(fraction, last_fraction);
    last_fraction = fraction;
    return fraction <= stop_after;
  }

  std::vector<ScanPoint> points;
  std::uint64_t declared = 0;
  double last_fraction = 0, stop_after = 2;
};

std::vector<ScanPoint> scan(std::uint64_t points, std::uint64_t seed) {
  Collector sink;
  EXPECT_TRUE(scan_bust({.points = points, .seed = seed}, sink).has_value());
  EXPECT_EQ(sink.declared, points);
  EXPECT_EQ(sink.last_fraction, 1.0);
  return std::move(sink.points);
}

/// FNV-1a over the bits of the floats, little-endian.
std::uint64_t hash(std::span<const ScanPoint> points) {
  std::uint64_t h = 0xCBF29CE484222325U;
  for (const ScanPoint& p : points) {
    for (const double value : {p.x, p.y, p.z, double{p.nx}, double{p.ny}, double{p.nz}}) {
      const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
      for (unsigned i = 0; i < 4; ++i) h = (h ^ ((bits >> (8 * i)) & 0xFFU)) * 0x100000001B3U;
    }
  }
  return h;
}

Vec3d gradient(const Vec3d& p) {
  constexpr double kStep = 0.005;
  Vec3d g;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3d d = kStep * Vec3d::Unit(axis);
    g[axis] = (bust_distance(p + d) - bust_distance(p - d)) / (2 * kStep);
  }
  return g;
}

/// First-order distance to the surface, mm: the bound divided by its slope.
double distance(const ScanPoint& p) {
  const Vec3d x{p.x, p.y, p.z};
  return bust_distance(x) / std::max(gradient(x).norm(), 1e-3);
}

TEST(Sample, HasExactlyThePointsAskedFor) {
  for (const std::uint64_t points : {1000U, 1001U, 7777U, 30000U}) EXPECT_EQ(scan(points, 1).size(), points);
}

TEST(Sample, IsTheSameForTheSameSeedOnEveryMachine) { EXPECT_EQ(hash(scan(20000, 1)), 2699378324134505192U); }

TEST(Sample, DiffersForAnotherSeed) { EXPECT_NE(hash(scan(2000, 1)), hash(scan(2000, 2))); }

TEST(Sample, LiesOnTheSurfaceExceptForNoiseAndAFewOutliers) {
  const auto points = scan(30000, 3);
  // Sigma is 0.02 to 0.059 mm along the ray and 0.02 mm an axis for a view's shift: 0.3 mm is beyond five sigmas of both.
  std::vector<double> off;
  for (const auto& p : points) off.push_back(std::abs(distance(p)));
  const auto far = static_cast<std::size_t>(std::count_if(off.begin(), off.end(), [](double d) { return d > 0.3; }));
  EXPECT_GE(far, 20U);                  // one point in a thousand is an outlier, and few of those hit the bust
  EXPECT_LE(far, points.size() / 250);  // and there are some flying pixels
  std::nth_element(off.begin(), off.begin() + std::ptrdiff_t(off.size() / 2), off.end());
  EXPECT_NEAR(off[off.size() / 2], 0.019, 0.006);
}

TEST(Sample, IsNotSwollen) {
  double sum = 0;
  std::size_t near = 0;
  for (const auto& p : scan(30000, 4)) {
    const double d = distance(p);
    if (std::abs(d) > 0.2) continue;
    sum += d;
    ++near;
  }
  EXPECT_NEAR(sum / static_cast<double>(near), 0.0, 0.006);
}

TEST(Sample, HasNoPointOfTheUnderside) {
  std::size_t low = 0;
  for (const auto& p : scan(30000, 5)) {
    EXPECT_GE(p.z, -0.3);
    // Well under the plinth, where only a scanner that saw through it could find points.
    low += p.z < 0.2 && std::hypot(p.x, p.y - 1.0) < 13.0 ? 1U : 0U;
  }
  EXPECT_LE(low, 2U);  // outliers can be anywhere
}

TEST(Sample, SeesEverySide) {
  const auto points = scan(30000, 6);
  const auto count = [&](auto predicate) {
    return static_cast<double>(std::count_if(points.begin(), points.end(), predicate)) / 30000.0;
  };
  EXPECT_GT(count([](const ScanPoint& p) { return p.x < 0; }), 0.4);
  EXPECT_GT(count([](const ScanPoint& p) { return p.x > 0; }), 0.4);
  EXPECT_GT(count([](const ScanPoint& p) { return p.y < 0 && p.z > 35; }), 0.1);  // the face
  EXPECT_GT(count([](const ScanPoint& p) { return p.y > 5 && p.z > 35; }), 0.1);  // the hair
  EXPECT_GT(count([](const ScanPoint& p) { return p.z > 57; }), 0.01);            // the crown
  EXPECT_GT(count([](const ScanPoint& p) { return p.z < 5; }), 0.05);             // the plinth
}

TEST(Sample, SeesShouldersAndChinFromBelowButNotTheUnderside) {
  std::size_t facing_down = 0;
  std::size_t underside = 0;
  for (const auto& p : scan(30000, 6)) {
    const Vec3d at{p.x, p.y, p.z};
    if (std::abs(distance(p)) > 0.2) continue;
    facing_down += p.z > 8 && gradient(at).normalized().z() < -0.9 ? 1U : 0U;
    underside += std::abs(p.z) < 0.02 && std::hypot(p.x, p.y - 1.0) < 10 ? 1U : 0U;
  }
  EXPECT_GT(facing_down, 100U);
  EXPECT_LE(underside, 2U) << "strays";
}

TEST(Sample, HasUnitNormalsThatFaceOutwards) {
  std::size_t near = 0, inwards = 0, good = 0;
  for (const auto& p : scan(100000, 7)) {
    const Vec3d n{p.nx, p.ny, p.nz};
    ASSERT_NEAR(n.norm(), 1.0, 1e-3);
    if (std::abs(distance(p)) > 0.2) continue;
    const double cosine = n.dot(gradient({p.x, p.y, p.z}).normalized());
    ++near;
    inwards += cosine < 0 ? 1U : 0U;
    good += cosine > 0.94 ? 1U : 0U;  // within 20 degrees
  }
  EXPECT_LT(static_cast<double>(inwards), 0.003 * static_cast<double>(near));
  EXPECT_GT(static_cast<double>(good), 0.75 * static_cast<double>(near));
}

TEST(Sample, StopsOnRequest) {
  Collector sink;
  sink.stop_after = 0.4;
  const auto result = scan_bust({.points = 5000}, sink);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code(), ErrorCode::kCancelled);
  EXPECT_LT(sink.last_fraction, 0.6);
}

TEST(Sample, RefusesTooFewAndTooManyPoints) {
  for (const std::uint64_t points : {std::uint64_t{0}, kMinSamplePoints - 1, kMaxSamplePoints + 1}) {
    Collector sink;
    const auto result = scan_bust({.points = points}, sink);
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code(), ErrorCode::kBadSetting);
  }
}

class SampleFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("plumbline_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string path(const char* name) const { return (folder_ / name).string(); }

  std::filesystem::path folder_;
};

TEST_F(SampleFile, IsLittleEndianPlyOfSixFloatsAPoint) {
  ASSERT_TRUE(write_bust_scan(path("bust.ply"), {.points = 2000, .seed = 9}).has_value());
  std::ifstream file(path("bust.ply"), std::ios::binary);
  const std::string all{std::istreambuf_iterator<char>(file), {}};
  const std::string end = "end_header\n";
  const std::size_t body = all.find(end) + end.size();
  const std::string header = all.substr(0, body);
  EXPECT_THAT(header, ::testing::StartsWith("ply\nformat binary_little_endian 1.0\ncomment "));
  EXPECT_THAT(header, HasSubstr("\nelement vertex 2000\nproperty float x\nproperty float y\nproperty float z\n"
                                "property float nx\nproperty float ny\nproperty float nz\nend_header\n"));
  EXPECT_THAT(header, HasSubstr("seed 9"));
  EXPECT_THAT(header, HasSubstr("mm"));
  ASSERT_EQ(all.size(), body + 2000 * 24);

  const auto points = scan(2000, 9);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto number = [&](std::size_t k) {
      std::uint32_t bits = 0;
      for (std::size_t b = 0; b < 4; ++b) {
        bits |= std::uint32_t{static_cast<unsigned char>(all[body + 24 * i + 4 * k + b])} << (8 * b);
      }
      return std::bit_cast<float>(bits);
    };
    ASSERT_EQ(double{number(0)}, points[i].x);
    ASSERT_EQ(double{number(1)}, points[i].y);
    ASSERT_EQ(double{number(2)}, points[i].z);
    ASSERT_EQ(number(3), points[i].nx);
    ASSERT_EQ(number(5), points[i].nz);
  }
}

TEST_F(SampleFile, IsNamedInTheErrorIfItCannotBeCreated) {
  const auto result = write_bust_scan(path("no/such/folder/bust.ply"), {.points = 1000});
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code(), ErrorCode::kCannotOpen);
  EXPECT_THAT(result.error().message(), HasSubstr("no/such/folder/bust.ply"));
}

TEST_F(SampleFile, IsNamedInTheErrorIfItCannotBeWritten) {
  if (!std::filesystem::is_character_file("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  const auto result = write_bust_scan("/dev/full", {.points = 1000});
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code(), ErrorCode::kCannotWrite);
  EXPECT_THAT(result.error().message(), HasSubstr("/dev/full"));
  EXPECT_TRUE(std::filesystem::exists("/dev/full"));
}

TEST_F(SampleFile, IsRemovedIfTheScanIsCancelled) {
  const auto result = write_bust_scan(path("bust.ply"), {.points = 5000}, [](double done) { return done < 0.5; });
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code(), ErrorCode::kCancelled);
  EXPECT_FALSE(std::filesystem::exists(path("bust.ply")));
}

TEST_F(SampleFile, IsKeptIfTheSettingsAreWrong) {
  std::ofstream(path("bust.ply")) << "mine";
  EXPECT_FALSE(write_bust_scan(path("bust.ply"), {.points = 3}).has_value());
  EXPECT_EQ(std::filesystem::file_size(path("bust.ply")), 4U);
}

TEST(CounterRng, MakesNormalDeviatesOfMeanZeroAndVarianceOne) {
  const CounterRng rng(1, 2);
  constexpr int kCount = 200000;
  double sum = 0, squares = 0;
  int beyond_two = 0;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const double x = rng.normal(i);
    sum += x;
    squares += x * x;
    beyond_two += std::abs(x) > 2 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.01);
  EXPECT_NEAR(squares / kCount, 1.0, 0.02);
  EXPECT_NEAR(beyond_two / double{kCount}, 0.0455, 0.004);
}

TEST(CounterRng, MakesUnrelatedStreams) {
  const CounterRng a(1, 1), b(1, 2), c(2, 1);
  int equal = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    equal += a.bits(i) == b.bits(i) || a.bits(i) == c.bits(i) || b.bits(i) == c.bits(i) ? 1 : 0;
  }
  EXPECT_EQ(equal, 0);
}

}  // namespace
}  // namespace plumbline::firmware
