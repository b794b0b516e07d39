#include "slicer/normals/normals.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

/// Random points, so that no two neighbourhoods are alike.
Surface scattered_torus(std::uint32_t points, double ring, double tube) {
  Random random(7);
  Surface surface;
  for (std::uint32_t i = 0; i < points; ++i) {
    const double u = random.uniform(0, 2 * kPi);
    const double v = random.uniform(0, 2 * kPi);
    const Vec3d n(std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v));
    surface.push_back({Vec3d(ring * std::cos(u), ring * std::sin(u), 0) + tube * n, n});
  }
  return surface;
}

/// A box around the origin. Each face is a square lattice of the given step, half a step away from the edges.
Surface centred_box(const Vec3d& half, double step) {
  Random unused(1);
  return box(-half, half, step, 0, unused);
}

/// A height field over [-1, 1]^2, seen from above only.
Surface relief(const std::function<double(double, double)>& height, std::uint32_t side) {
  Surface surface;
  constexpr double kStep = 1e-5;
  for (std::uint32_t j = 0; j < side; ++j) {
    for (std::uint32_t i = 0; i < side; ++i) {
      const double x = 2 * (i + 0.5) / side - 1;
      const double y = 2 * (j + 0.5) / side - 1;
      const Vec3d n((height(x - kStep, y) - height(x + kStep, y)) / (2 * kStep),
                    (height(x, y - kStep) - height(x, y + kStep)) / (2 * kStep), 1);
      surface.push_back({Vec3d(x, y, height(x, y)), n / std::sqrt(n.dot(n))});
    }
  }
  return surface;
}

Surface operator+(Surface a, const Surface& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Surface with_noise(Surface surface, double deviation) {
  Random random(11);
  add_noise(surface, deviation, 0, random);
  return surface;
}

Surface mirrored_normals(Surface surface) {
  for (SurfacePoint& p : surface) p.normal = -p.normal;
  return surface;
}

/// A cloud in its own arena, in the order of its tree, and the surface it came from in the same order.
class NormalsTest : public ::testing::Test {
 protected:
  void SetUp() override { omp_set_num_threads(2); }

  /// @param known  whether the scan has a point's normal; empty: it has none
  void load(const Surface& surface, const std::vector<bool>& known = {}) {
    block_.assign(std::size_t{200} * surface.size() + kMiB, std::byte{0});
    arena_.emplace(block_);
    cloud_ = cloud_of(surface, *arena_);
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (known.empty() || !known[i]) cloud_.normal[i] = PackedNormal{};
    }
    tree_ = value_of(KdTree3::build(cloud_.positions(), *arena_, "test"));
    surface_.clear();
    for (const std::uint32_t i : tree_.order()) surface_.push_back(surface[i]);
    cloud_.reorder(tree_.order());
  }

  std::uint32_t estimate() {
    const auto filled = estimate_normals(cloud_, tree_, *arena_);
    if (!filled) {
      ADD_FAILURE() << filled.error().message();
      return 0;
    }
    return filled->estimated;
  }

  double cosine(std::uint32_t i) const { return cloud_.normal[i].unpack().cast<double>().dot(surface_[i].normal); }
  std::uint32_t facing_the_wrong_way() const {
    std::uint32_t wrong = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) wrong += cosine(i) > 0 ? 0U : 1U;
    return wrong;
  }
  double worst_degrees() const {
    double worst = 1;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) worst = std::min(worst, cosine(i));
    return std::acos(worst) * 180 / kPi;
  }
  double mean_degrees() const {
    double sum = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) sum += std::acos(std::min(1.0, cosine(i))) * 180 / kPi;
    return sum / cloud_.size;
  }

  std::vector<std::byte> block_;
  std::optional<Arena> arena_;
  Cloud cloud_;
  KdTree3 tree_;
  Surface surface_;
};

TEST_F(NormalsTest, OfAPlaneArePerpendicularToItAndFaceOneWay) {
  load(relief([](double x, double y) { return 0.3 * x - 0.2 * y; }, 50));
  EXPECT_EQ(estimate(), 2500U);
  const std::uint32_t wrong = facing_the_wrong_way();
  EXPECT_TRUE(wrong == 0 || wrong == 2500) << wrong;                                          // a plane has no outside
  for (std::uint32_t i = 0; i < cloud_.size; ++i) EXPECT_NEAR(std::abs(cosine(i)), 1, 5e-5);  // six bytes a normal
}

TEST_F(NormalsTest, OfASphereFaceOutwards) {
  load(sphere(20000, 10, Vec3d(100, -50, 20)));
  EXPECT_EQ(estimate(), 20000U);
  EXPECT_EQ(facing_the_wrong_way(), 0U);
  EXPECT_LT(worst_degrees(), 2.0);
}

TEST_F(NormalsTest, OfATorusFaceOutwardsOnItsInnerSideToo) {
  load(scattered_torus(20000, 10, 4));
  estimate();
  EXPECT_EQ(facing_the_wrong_way(), 0U);
  EXPECT_LT(mean_degrees(), 3.0);
}

TEST_F(NormalsTest, OfABoxFaceOutwardsAcrossItsEdges) {
  load(centred_box(Vec3d(5, 4, 3), 0.1));
  estimate();
  EXPECT_EQ(facing_the_wrong_way(), 0U);
}

TEST_F(NormalsTest, OfAThinSheetFaceAwayFromEachOtherOnItsTwoSides) {
  load(centred_box(Vec3d(5, 4, 0.25), 0.1));
  estimate();
  EXPECT_EQ(facing_the_wrong_way(), 0U);
}

TEST_F(NormalsTest, OfThreeSeparateShellsEachFaceOutwards) {
  load(sphere(8000, 10, Vec3d(0, 0, 0)) + sphere(7000, 10, Vec3d(25, 0, 0)) + sphere(500, 2, Vec3d(0, 15, 9)));
  estimate();
  EXPECT_EQ(facing_the_wrong_way(), 0U);
}

// As a scanner that drifts sees it. A thin shell has the same points; solids are more common.
TEST_F(NormalsTest, OfABallScannedTwiceFaceOutwards) {
  const std::uint32_t points = sphere_points(10, 0.2);
  load(with_noise(sphere(points, 10, Vec3d(0, 0, 0)) + sphere(points - 7, 10, Vec3d(0.2, 0, 0)), 0.02));
  estimate();
  EXPECT_LT(facing_the_wrong_way(), 0.01 * cloud_.size);
}

TEST_F(NormalsTest, OfACavityFaceIntoIt) {
  load(sphere(20000, 10, Vec3d(0, 0, 0)) + mirrored_normals(sphere(5000, 5, Vec3d(1, 0, 0))));
  estimate();
  EXPECT_EQ(facing_the_wrong_way(), 0U);
}

TEST_F(NormalsTest, OfSheetsWithGapsBetweenThemFaceOutwards) {
  Surface sheets;
  for (const SurfacePoint& s : sphere(40000, 10, Vec3d(0, 0, 0))) {
    const bool gap = std::abs(std::fmod(std::abs(s.position[0]) + 1, 4.0)) < 0.6 || std::abs(s.position[2] - 2) < 0.4;
    if (!gap) sheets.push_back(s);
  }
  load(sheets);
  estimate();
  EXPECT_EQ(facing_the_wrong_way(), 0U);
}

TEST_F(NormalsTest, OfAReliefSeenFromItsFrontFaceTheScanner) {
  load(relief([](double x, double y) { return 0.6 * std::cos(1.5 * x) * std::cos(1.5 * y) + 0.05 * std::sin(9 * x); },
              120));
  estimate();
  EXPECT_EQ(facing_the_wrong_way(), 0U);
}

TEST_F(NormalsTest, OfASphereWithNoiseOfHalfTheSpacingFaceOutwards) {
  const double spacing = std::sqrt(4 * kPi * 100 / 20000);
  load(with_noise(sphere(20000, 10, Vec3d(0, 0, 0)), 0.5 * spacing));
  EXPECT_EQ(estimate(), 20000U);
  EXPECT_LT(facing_the_wrong_way(), 20U);
  EXPECT_LT(mean_degrees(), 12.0);
}

TEST_F(NormalsTest, OfOutliersDoNotTurnTheObject) {
  Random random(3);
  Surface surface = sphere(20000, 10, Vec3d(0, 0, 0));
  for (int i = 0; i < 400; ++i) {
    const double x = random.uniform(-100, 100);
    const double y = random.uniform(-100, 100);
    surface.push_back({Vec3d(x, y, random.uniform(-100, 100)), Vec3d(0, 0, 1)});
  }
  load(surface);
  estimate();
  std::uint32_t wrong = 0;
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    const bool outlier = std::abs(surface_[i].position.dot(surface_[i].position) - 100) > 1e-6;
    if (!outlier && cosine(i) <= 0) ++wrong;
  }
  EXPECT_EQ(wrong, 0U);
}

TEST_F(NormalsTest, ThatAreKnownAreKeptAndDecideForTheOthers) {
  // Every tenth normal is known and faces inwards, against the rules for unknown ones.
  std::vector<bool> known(10000);
  for (std::size_t i = 0; i < known.size(); i += 10) known[i] = true;
  load(mirrored_normals(sphere(10000, 10, Vec3d(0, 0, 0))), known);
  std::vector<PackedNormal> before(cloud_.normal.begin(), cloud_.normal.begin() + cloud_.size);
  EXPECT_EQ(estimate(), 9000U);
  EXPECT_EQ(facing_the_wrong_way(), 0U);
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    if (before[i].known()) {
      EXPECT_EQ(std::memcmp(&before[i], &cloud_.normal[i], sizeof(PackedNormal)), 0);
    }
  }
}

TEST_F(NormalsTest, OfAFlatLidTakeTheirSideFromTheKnownOnesAroundIt) {
  Surface surface;
  std::vector<bool> known;
  for (const SurfacePoint& p : centred_box(Vec3d(5, 4, 3), 0.1)) {
    const bool lid = p.normal[2] > 0.5;
    if (lid && (std::abs(p.position[0]) > 4.5 || std::abs(p.position[1]) > 3.5)) continue;
    known.push_back(!lid);
    surface.push_back(p);
  }
  load(surface, known);
  EXPECT_GT(estimate(), 0U);
  EXPECT_EQ(facing_the_wrong_way(), 0U);
}

TEST_F(NormalsTest, StayTheSameWhenAllAreKnown) {
  load(mirrored_normals(sphere(2000, 10, Vec3d(0, 0, 0))), std::vector<bool>(2000, true));
  EXPECT_EQ(estimate(), 0U);
  EXPECT_EQ(facing_the_wrong_way(), 0U);
}

TEST_F(NormalsTest, StayUnknownOnALineAndInOnePlace) {
  Surface surface;
  for (int i = 0; i < 100; ++i) surface.push_back({Vec3d(i, 0, 0), Vec3d(0, 0, 1)});
  for (int i = 0; i < 100; ++i) surface.push_back({Vec3d(0, 1000, 0), Vec3d(0, 0, 1)});
  load(surface);
  EXPECT_EQ(estimate(), 0U);
}

TEST_F(NormalsTest, OfVeryFewPointsGiveNoError) {
  for (std::uint32_t points = 1; points < 40; ++points) {
    load(sphere(points, 10, Vec3d(0, 0, 0)));
    EXPECT_LE(estimate(), points);
  }
}

TEST_F(NormalsTest, AreTheSameBitsForAnyNumberOfThreads) {
  const Surface surface = with_noise(
      sphere(6000, 10, Vec3d(0, 0, 0)) + sphere(3000, 5, Vec3d(16, 0, 0)) + centred_box(Vec3d(3, 2, 1), 0.2), 0.05);
  std::vector<PackedNormal> first;
  for (const int threads : {1, 2, 3, 8}) {
    omp_set_num_threads(threads);
    load(surface);
    estimate();
    const std::vector<PackedNormal> now(cloud_.normal.begin(), cloud_.normal.begin() + cloud_.size);
    if (first.empty()) first = now;
    EXPECT_EQ(std::memcmp(first.data(), now.data(), now.size() * sizeof(PackedNormal)), 0) << threads << " threads";
  }
}

TEST_F(NormalsTest, TakeNoMoreMemoryThanPlannedAndReleaseIt) {
  for (const std::uint32_t points : {10U, 1000U, 30000U}) {
    load(sphere(points, 10, Vec3d(0, 0, 0)));
    const std::size_t before = arena_->used();
    arena_->reset_peak();
    estimate();
    EXPECT_EQ(arena_->used(), before);
    EXPECT_LE(arena_->peak() - before, normals_bytes(points) + 8 * Arena::kAlignment);
  }
}

TEST_F(NormalsTest, ReturnOutOfMemoryWhenTheArenaIsFull) {
  load(sphere(30000, 10, Vec3d(0, 0, 0)));
  // Arenas that are too small by any number of steps: every stage must notice.
  for (std::size_t left = 0; left + 4096 < normals_bytes(30000); left += 16384) {
    const ArenaScope scope(*arena_);
    ASSERT_TRUE(arena_->take_top<std::byte>(arena_->available() - left, "test").has_value());
    const auto filled = estimate_normals(cloud_, tree_, *arena_);
    if (filled) continue;  // a clean sphere is one sheet, which needs less than planned
    EXPECT_EQ(filled.error().code(), ErrorCode::kOutOfMemory);
    EXPECT_THAT(filled.error().message(), HasSubstr("normals"));
    for (std::uint32_t i = 0; i < cloud_.size; ++i) cloud_.normal[i] = PackedNormal{};
  }
}

}  // namespace
}  // namespace plumbline
