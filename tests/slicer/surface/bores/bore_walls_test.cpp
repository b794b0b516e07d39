#include "slicer/surface/bores/bore_walls.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/stop.hpp"

namespace plumbline {
namespace bore_walls_test {

using namespace testing;

constexpr double kBore = 1;      ///< radius, mm
constexpr double kHigh = 12;     ///< height of the block, mm
constexpr double kSide = 12;     ///< of the block, mm
constexpr double kDense = 0.12;  ///< spacing where every view saw, mm
constexpr double kRare = 0.5;    ///< spacing deep in a bore, mm

double from_axis(const Vec3d& p) { return std::hypot(p[0] - kSide / 2, p[1] - kSide / 2); }

/// Points of the wall of the bore from z = low to high.
Surface wall(double low, double high, double spacing, Random& random) {
  Surface surface;
  const int around = static_cast<int>(2 * kPi * kBore / spacing);
  for (double z = low; z < high; z += spacing) {
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * kPi * (k + random.uniform(-0.3, 0.3)) / around;
      const Vec3d inwards(-std::cos(angle), -std::sin(angle), 0);
      const double jitter = spacing * random.uniform(-0.3, 0.3);
      surface.push_back({Vec3d(kSide / 2, kSide / 2, std::clamp(z + jitter, low, high)) - kBore * inwards, inwards});
    }
  }
  return surface;
}

/// A block with a bore through it. From either mouth the scanner saw 1.5 mm of its wall well, and 1.5 mm more sparsely.
Surface bored_block(Random& random) {
  Surface surface;
  for (const SurfacePoint& p : box({0, 0, 0}, {kSide, kSide, kHigh}, kDense, 0.3, random)) {
    if (from_axis(p.position) > kBore) surface.push_back(p);
  }
  for (const double from : {0.0, kHigh - 1.5}) append(surface, wall(from, from + 1.5, kDense, random));
  for (const double from : {1.5, kHigh - 3}) append(surface, wall(from, from + 1.5, kRare, random));
  return surface;
}

/// Bottoms of the bore at 4.5 mm from either mouth.
Surface bottoms(Random& random) {
  Surface surface;
  for (const SurfacePoint& p : sheet({0, 0, 4.5}, {0, kSide, 0}, {kSide, 0, 0}, kRare, 0.3, random)) {
    if (from_axis(p.position) < kBore) surface.push_back(p);
  }
  for (const SurfacePoint& p : sheet({0, 0, kHigh - 4.5}, {kSide, 0, 0}, {0, kSide, 0}, kRare, 0.3, random)) {
    if (from_axis(p.position) < kBore) surface.push_back(p);
  }
  return surface;
}

struct Continued {
  ArenaBlock block{64 * kMiB};
  Cloud cloud;
  BoreWalls walls;
  std::uint32_t seen = 0;

  explicit Continued(const Surface& surface) {
    Arena& arena = *block;
    const auto points = static_cast<std::uint32_t>(surface.size());
    cloud = value_of(Cloud::create(points + Cloud::spare(points), arena));
    const Cloud scan = cloud_of(surface, arena);
    std::copy(scan.position.begin(), scan.position.end(), cloud.position.begin());
    std::copy(scan.normal.begin(), scan.normal.end(), cloud.normal.begin());
    cloud.size = seen = points;
    const KdTree3 tree = sort_by_tree(cloud, arena);
    const float epsilon = value_of(density_epsilon(cloud, tree, arena));
    ClusteringResult clustering = value_of(cluster(cloud, tree, epsilon, arena));
    const std::size_t used = arena.used();
    arena.reset_peak();
    walls = value_of(continue_bore_walls(cloud, tree, clustering, arena));
    EXPECT_EQ(arena.used(), used);
    EXPECT_LE(arena.peak() - used, bore_walls_bytes(points));
  }
};

TEST(BoreWalls, AreExtendedBetweenThePartsSeenFromBothEnds) {
  Random random(1);
  const Continued bore(bored_block(random));
  ASSERT_GT(bore.walls.points, 0U);
  EXPECT_EQ(bore.cloud.size, bore.seen + bore.walls.points);
  EXPECT_EQ(bore.cloud.continued, bore.walls.points);
  const double unseen = 2 * kPi * kBore * (kHigh - 6);
  EXPECT_GT(bore.walls.area, 0.8 * unseen);
  EXPECT_LT(bore.walls.area, 1.6 * unseen);
  std::uint32_t where_it_was_seen_well = 0;
  for (std::uint32_t i = bore.seen; i < bore.cloud.size; ++i) {
    const Vec3d p = bore.cloud.position[i].cast<double>();
    ASSERT_NEAR(from_axis(p), kBore, 0.01);
    where_it_was_seen_well += p[2] < 1 || p[2] > kHigh - 1 ? 1 : 0;
    const Vec3d inwards = (Vec3d(kSide / 2, kSide / 2, p[2]) - p).normalized();
    ASSERT_GT(bore.cloud.normal[i].unpack().cast<double>().dot(inwards), 0.99);
    ASSERT_GT(bore.cloud.radius[i], 0);
    ASSERT_NE(bore.cloud.normal[i].point_class, PointClass::kNoise);
  }
  EXPECT_LT(where_it_was_seen_well, bore.walls.points / 50);
}

// Deep in a bore the nearest points lie all around it, so normals estimated from them have any direction.
TEST(BoreWalls, OfARoundBoreDontDependOnTheNormalsOfSparsePoints) {
  Random random(5);
  Surface surface = bored_block(random);
  const auto deep = [](const Vec3d& p) { return p[2] > 1.6 && p[2] < kHigh - 1.6 && from_axis(p) < kBore + 0.01; };
  for (SurfacePoint& p : surface) {
    if (deep(p.position) && random.below(3) > 0) p.normal = random.vector().normalized();
  }
  const Continued bore(surface);
  EXPECT_GT(bore.walls.area, 0.8 * 2 * kPi * kBore * (kHigh - 6));
  std::uint32_t walls = 0;
  for (std::uint32_t i = 0; i < bore.seen; ++i) {
    const Vec3d p = bore.cloud.position[i].cast<double>();
    if (!deep(p)) continue;
    ++walls;
    const Vec3d inwards = (Vec3d(kSide / 2, kSide / 2, p[2]) - p).normalized();
    ASSERT_GT(bore.cloud.normal[i].unpack().cast<double>().dot(inwards), 0.99);
    ASSERT_NE(bore.cloud.normal[i].point_class, PointClass::kNoise);
  }
  EXPECT_GT(walls, 50U);
}

TEST(BoreWalls, OfAPipeDontChangeItsOutside) {
  Random random(8);
  Surface surface;
  for (const double from : {0.0, kHigh - 1.5}) append(surface, wall(from, from + 1.5, kDense, random));
  for (const double from : {1.5, kHigh - 3}) append(surface, wall(from, from + 1.5, kRare, random));
  const double outside = kBore + 0.2;
  const auto add_outside = [&](double from, double to, double spacing) {
    for (const SurfacePoint& p : wall(from, to, spacing, random)) {
      const Vec3d out = -p.normal;
      surface.push_back({p.position + out * (outside - kBore), out});
    }
  };
  add_outside(0, 4, kDense);
  add_outside(4, 8, kRare);
  add_outside(8, kHigh, kDense);
  const Continued pipe(surface);
  EXPECT_GT(pipe.walls.points, 0U);
  std::uint32_t rare = 0;
  for (std::uint32_t i = 0; i < pipe.cloud.size; ++i) {
    const Vec3d p = pipe.cloud.position[i].cast<double>();
    if (from_axis(p) < outside - 0.01) continue;
    rare += p[2] > 4.5 && p[2] < 7.5 && pipe.cloud.normal[i].point_class != PointClass::kNoise ? 1 : 0;
    const Vec3d inwards = (Vec3d(kSide / 2, kSide / 2, p[2]) - p).normalized();
    ASSERT_LT(pipe.cloud.normal[i].unpack().cast<double>().dot(inwards), -0.99);
  }
  EXPECT_GT(rare, 50U) << "its sparse part is not noise";
}

TEST(BoreWalls, OfASquareBoreAreExtendedInTheirPlanes) {
  Random random(6);
  Surface surface;
  const auto square = [](const Vec3d& p) {
    return std::max(std::abs(p[0] - kSide / 2), std::abs(p[1] - kSide / 2)) - kBore;
  };
  for (const SurfacePoint& p : box({0, 0, 0}, {kSide, kSide, kHigh}, kDense, 0.3, random)) {
    if (square(p.position) > 0) surface.push_back(p);
  }
  const double low = kSide / 2 - kBore;
  const auto walls = [&](double from, double to, double spacing) {
    // The four sides of a box, turned inside out.
    for (const SurfacePoint& p : box({low, low, from}, {low + 2 * kBore, low + 2 * kBore, to}, spacing, 0.3, random)) {
      if (std::abs(p.normal[2]) < 0.5) surface.push_back({p.position, -p.normal});
    }
  };
  for (const double from : {0.0, kHigh - 1.5}) walls(from, from + 1.5, kDense);
  for (const double from : {1.5, kHigh - 3}) walls(from, from + 1.5, kRare);
  const Continued bore(surface);
  EXPECT_GT(bore.walls.area, 0.4 * 8 * kBore * (kHigh - 6));
  for (std::uint32_t i = bore.seen; i < bore.cloud.size; ++i) {
    ASSERT_NEAR(square(bore.cloud.position[i].cast<double>()), 0, 0.2);
  }
}

TEST(BoreWalls, AreNotExtendedAcrossTheGapOfAFork) {
  Random random(7);
  Surface surface;
  const auto prong = [&](double low, double high) {
    for (const SurfacePoint& p : box({0, 0, low}, {kSide, kSide, high}, kDense, 0.3, random)) {
      if (from_axis(p.position) > kBore) surface.push_back(p);
    }
    append(surface, wall(low, low + 0.5, kDense, random));
    append(surface, wall(high - 0.5, high, kDense, random));
    append(surface, wall(low + 0.5, high - 0.5, kRare, random));
  };
  prong(0, 4);
  prong(7, 11);
  const Continued fork(surface);
  for (std::uint32_t i = fork.seen; i < fork.cloud.size; ++i) {
    const double z = static_cast<double>(fork.cloud.position[i][2]);
    ASSERT_FALSE(z > 4.1 && z < 6.9) << "a pipe in the air";
  }
}

TEST(BoreWalls, AreNotExtendedThroughABottomThatWasSeen) {
  Random random(2);
  Surface surface = bored_block(random);
  append(surface, bottoms(random));
  EXPECT_EQ(Continued(surface).walls.points, 0U);
}

TEST(BoreWalls, AreNotExtendedOnTheOutsideOfTheObject) {
  Random random(3);
  // Two blocks in line: their sides could be joined to one wall across the air between.
  Surface surface = box({0, 0, 0}, {6, 6, 4}, kDense, 0.3, random);
  append(surface, box({0, 0, 8}, {6, 6, 12}, kDense, 0.3, random));
  // One side of each is sparse.
  std::erase_if(surface, [&](const SurfacePoint& p) { return p.normal[0] > 0.5 && random.uniform() > 0.06; });
  const Continued blocks(surface);
  EXPECT_EQ(blocks.walls.points, 0U);
}

TEST(BoreWalls, AreExtendedAsFarAsTheCloudHasRoom) {
  Random random(1);
  const Surface surface = bored_block(random);
  ArenaBlock block(64 * kMiB);
  Cloud cloud = cloud_of(surface, *block);
  const KdTree3 tree = sort_by_tree(cloud, *block);
  const float epsilon = value_of(density_epsilon(cloud, tree, *block));
  ClusteringResult clustering = value_of(cluster(cloud, tree, epsilon, *block));
  EXPECT_EQ(value_of(continue_bore_walls(cloud, tree, clustering, *block)).points, 0U);
  EXPECT_EQ(cloud.size, surface.size());
}

TEST(BoreWalls, StopWhenCancelled) {
  StopAtThird stop;
  Random random(1);
  ArenaBlock block(64 * kMiB);
  Cloud cloud = cloud_of(bored_block(random), *block);
  const KdTree3 tree = sort_by_tree(cloud, *block);
  const float epsilon = value_of(density_epsilon(cloud, tree, *block));
  ClusteringResult clustering = value_of(cluster(cloud, tree, epsilon, *block));
  const auto walls = continue_bore_walls(cloud, tree, clustering, *block, {&stop, Stage::kClustering});
  ASSERT_FALSE(walls);
  EXPECT_EQ(walls.error().code(), ErrorCode::kCancelled);
  EXPECT_EQ(stop.reports, 3);
}

TEST(BoreWalls, AreNotSearchedWhereMuchOfTheScanIsSparse) {
  Random random(1);
  Surface surface = bored_block(random);
  // A large plate, far away and as sparse as the walls.
  append(surface, sheet({-20, -20, 40}, {50, 0, 0}, {0, 50, 0}, kRare, 0.3, random));
  EXPECT_EQ(Continued(surface).walls.points, 0U);
}

// The winding number alone would plug the bore, since two caps are less surface than a tube.
TEST(BoreWalls, KeepTheBoreOpen) {
  Random random(4);
  SliceSettings settings = settings_with_pitch(0.1F);
  settings.confidence = true;
  const Slicing sliced(binary_ply(bored_block(random)), settings, 128 * kMiB);
  EXPECT_GT(sliced.report().lengths.bore_walls.value, 0);
  EXPECT_EQ(sliced.report().components.solids, 1U);
  const auto distance = [](const Vec3d& p) {
    const double outside = std::max({-p[0], p[0] - kSide, -p[1], p[1] - kSide, -p[2], p[2] - kHigh});
    return std::max(outside, kBore - from_axis(p));
  };
  EXPECT_EQ(sliced.wrong_voxels(distance, 0.25), 0U);
}

}  // namespace bore_walls_test
}  // namespace plumbline
