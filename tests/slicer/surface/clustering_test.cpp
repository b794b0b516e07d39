#include "slicer/surface/clustering.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// Textbook version of thesis III-2.b: compares every pair of points, in double precision.
struct Textbook {
  std::vector<PointClass> type;
  std::vector<bool> core;
  std::vector<std::uint32_t> near;  ///< points within epsilon, itself included

  Textbook(const Cloud& cloud, double epsilon) {
    const std::uint32_t n = cloud.size;
    const auto distance = [&](std::uint32_t i, std::uint32_t j) {
      const double cosine = cloud.normal[i].unpack().cast<double>().dot(cloud.normal[j].unpack().cast<double>());
      if (!(cosine > 0)) return std::numeric_limits<double>::infinity();
      return (cloud.position[i].cast<double>() - cloud.position[j].cast<double>()).norm() / cosine;
    };
    for (std::uint32_t i = 0; i < n; ++i) {
      const Vec3d normal = cloud.normal[i].unpack().cast<double>();
      const double elevation = std::asin(std::clamp(normal[2], -1.0, 1.0)) * 180 / kPi;
      type.push_back(elevation > 5    ? PointClass::kExiting
                     : elevation < -5 ? PointClass::kEntering
                                      : PointClass::kNeutral);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      std::uint32_t all = 0;
      std::uint32_t same = 0;
      for (std::uint32_t j = 0; j < n; ++j) {
        if (!(distance(i, j) <= epsilon)) continue;
        ++all;
        same += type[i] == type[j] ? 1 : 0;
      }
      near.push_back(all);
      core.push_back(all > kMinPts && same > kSameTypeShare * all);
    }
    const std::vector<PointClass> types = type;
    for (std::uint32_t i = 0; i < n; ++i) {
      bool joins = core[i];
      for (std::uint32_t j = 0; j < n && !joins; ++j) {
        joins = core[j] && types[i] == types[j] && distance(i, j) <= epsilon;
      }
      if (!joins && near[i] < kMinPts) type[i] = PointClass::kNoise;
    }
  }
};

/// Epsilon is slightly above the median. At the median one pair would be exactly epsilon apart, where the two programs
/// may round differently.
void expect_textbook_classes(const Surface& surface) {
  ArenaBlock arena(16 * kMiB);
  Cloud cloud = cloud_of(surface, *arena);
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  const float epsilon = value_of(density_epsilon(cloud, tree, *arena)) * 1.0001F;
  const std::size_t before = arena->top_used();
  const ClusteringResult result = value_of(cluster(cloud, tree, epsilon, *arena, {}, SparseSurface::kNoise));
  EXPECT_EQ(arena->top_used(), before);

  const Textbook book(cloud, epsilon);
  std::vector<PointClass> types;
  for (std::uint32_t i = 0; i < cloud.size; ++i) types.push_back(cloud.normal[i].point_class);
  EXPECT_EQ(types, book.type);

  EXPECT_EQ(result.core_points, std::count(book.core.begin(), book.core.end(), true));
  for (const PointClass c : {PointClass::kEntering, PointClass::kExiting, PointClass::kNeutral, PointClass::kNoise}) {
    EXPECT_EQ(result.points[c], std::count(book.type.begin(), book.type.end(), c)) << "class " << static_cast<int>(c);
  }
}

TEST(Clustering, ClassifiesParallelSheetsThatFaceOppositeWaysLikeTheTextbook) {
  Random random(11);
  Surface surface = sheet({0, 0, 0}, {0, 4, 0}, {4, 0, 0}, 0.12, 0.5, random);
  append(surface, sheet({0, 0, 0.2}, {4, 0, 0}, {0, 4, 0}, 0.12, 0.5, random));
  expect_textbook_classes(surface);
}

TEST(Clustering, ClassifiesParallelSheetsThatFaceTheSameWayLikeTheTextbook) {
  Random random(12);
  Surface surface = sheet({0, 0, 0}, {4, 0, 0}, {0, 4, 0}, 0.12, 0.5, random);
  append(surface, sheet({1, 1, 0.3}, {4, 0, 0}, {0, 4, 0}, 0.12, 0.5, random));
  append(surface, sheet({0, 0, 4}, {4, 0, 0}, {0, 4, 0}, 0.12, 0.5, random));  // too far to join them
  expect_textbook_classes(surface);
}

TEST(Clustering, ClassifiesANoisySphereLikeTheTextbook) {
  Random random(13);
  Surface surface = sphere(2000, 3, {5, 5, 5});
  add_noise(surface, 0.05, 0.15, random);
  shuffle(surface, random);
  expect_textbook_classes(surface);
}

TEST(Clustering, ClassifiesTheEdgesOfACubeLikeTheTextbook) {
  Random random(14);
  Surface surface = box({0, 0, 0}, {3, 3, 3}, 0.16, 0.4, random);
  add_noise(surface, 0.01, 0.05, random);
  expect_textbook_classes(surface);
}

TEST(Clustering, FindsTheSameOutliersAsTheTextbook) {
  Random random(15);
  Surface surface = sphere(1200, 3, {5, 5, 5});
  for (int i = 0; i < 300; ++i) {
    surface.push_back(
        {Vec3d(random.uniform(0, 10), random.uniform(0, 10), random.uniform(0, 10)), random.vector().normalized()});
  }
  shuffle(surface, random);
  expect_textbook_classes(surface);
}

TEST(Clustering, ClassifiesSurfacesOfDifferentDensityLikeTheTextbook) {
  Random random(16);
  Surface surface = sheet({0, 0, 0}, {3, 0, 0}, {0, 3, 0}, 0.1, 0.5, random);
  append(surface, sheet({3, 0, 0}, {3, 0, 0.8}, {0, 3, 0}, 0.25, 0.5, random));
  append(surface, sheet({6, 0, 0.8}, {3, 0, 0.1}, {0, 3, 0}, 0.4, 0.5, random));
  expect_textbook_classes(surface);
}

// Seven points in one place don't have thirty neighbours. The rescue of sparse surface once kept them even with a
// radius of 0.
TEST(Clustering, CallsCopiesOfALonePointNoiseLikeTheTextbook) {
  Random random(17);
  Surface surface = sheet({0, 0, 0}, {4, 0, 0}, {0, 4, 0}, 0.12, 0.5, random);
  for (int i = 0; i < 7; ++i) surface.push_back({Vec3d(2, 2, 9), Vec3d(0, 0, 1)});
  expect_textbook_classes(surface);
}

TEST(DensityEpsilon, IsTheMedianOfTheSixtiethNeighbourDistances) {
  for (const std::uint32_t points : {1500U, 1501U}) {
    Random random(21);
    Surface surface = sphere(points, 4, {5, 5, 5});
    add_noise(surface, 0.2, 0, random);
    ArenaBlock arena(4 * kMiB);
    Cloud cloud = cloud_of(surface, *arena);
    const KdTree3 tree = sort_by_tree(cloud, *arena);
    std::vector<double> sixtieth;
    for (const Vec3f& p : cloud.positions()) {
      std::vector<double> distances;
      for (const Vec3f& q : cloud.positions()) distances.push_back((p.cast<double>() - q.cast<double>()).norm());
      std::nth_element(distances.begin(), distances.begin() + 60, distances.end());  // 0 is the point itself
      sixtieth.push_back(distances[60]);
    }
    std::sort(sixtieth.begin(), sixtieth.end());
    const double median = (sixtieth[points / 2] + sixtieth[(points - 1) / 2]) / 2;
    EXPECT_NEAR(value_of(density_epsilon(cloud, tree, *arena)), median, 1e-5 * median);
  }
}

TEST(DensityEpsilon, OfASampleIsWithinOnePercentOfTheWholeClouds) {
  Random random(22);
  Surface surface = sphere(40000, 10, {20, 20, 20});
  append(surface, sheet({0, 0, 0}, {40, 0, 0}, {0, 40, 0}, 0.3, 0.5, random));  // much sparser
  add_noise(surface, 0.03, 0, random);
  shuffle(surface, random);
  ArenaBlock arena(16 * kMiB);
  Cloud cloud = cloud_of(surface, *arena);
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  ASSERT_GT(cloud.size, 2 * kMedianSample);
  const float full = value_of(density_epsilon(cloud, tree, *arena, cloud.size));
  const float sampled = value_of(density_epsilon(cloud, tree, *arena));
  EXPECT_NEAR(sampled, full, 0.01 * full);
  EXPECT_NE(sampled, full) << "nothing was sampled";
}

TEST(DensityEpsilon, OfPointsInOnePlaceIsZero) {
  ArenaBlock arena(kMiB);
  Cloud cloud = cloud_of(Surface(200, {Vec3d(1, 2, 3), Vec3d(0, 0, 1)}), *arena);
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  EXPECT_EQ(value_of(density_epsilon(cloud, tree, *arena)), 0);
}

/// Clusters a dense sheet next to one with the given spacing. Returns the share of the second sheet that is not noise.
double kept_share_of_a_sheet_with_spacing(double spacing, SparseSurface sparse) {
  Random random(31);
  Surface surface = sheet({0, 0, 0}, {10, 0, 0}, {0, 10, 0}, 0.1, 0.3, random);
  append(surface, sheet({20, 0, 0}, {10, 0, 0}, {0, 10, 0}, spacing, 0.3, random));
  ArenaBlock arena(8 * kMiB);
  const ClusteredScan scan = clustered(surface, *arena, sparse);
  double kept = 0;
  double all = 0;
  for (std::uint32_t i = 0; i < scan.cloud.size; ++i) {
    if (scan.cloud.position[i][0] < 15) continue;
    ++all;
    kept += scan.cloud.normal[i].point_class != PointClass::kNoise ? 1 : 0;
  }
  return kept / all;
}

TEST(Clustering, KeepsSparseSurfaceThatTheThesisCallsNoise) {
  EXPECT_EQ(kept_share_of_a_sheet_with_spacing(0.3, SparseSurface::kNoise), 0);
  EXPECT_GT(kept_share_of_a_sheet_with_spacing(0.3, SparseSurface::kKept), 0.98);
  EXPECT_GT(kept_share_of_a_sheet_with_spacing(0.45, SparseSurface::kKept), 0.9);
  EXPECT_GT(kept_share_of_a_sheet_with_spacing(1, SparseSurface::kKept), 0.9);
  EXPECT_EQ(kept_share_of_a_sheet_with_spacing(4, SparseSurface::kKept), 0);
}

TEST(Clustering, CallsOutliersBesideASurfaceNoiseEvenWhenItKeepsSparseSurface) {
  Random random(32);
  Surface surface = sheet({0, 0, 0}, {10, 0, 0}, {0, 10, 0}, 0.1, 0.3, random);
  const std::size_t on_sheet = surface.size();
  for (int i = 0; i < 100; ++i) {
    surface.push_back(
        {Vec3d(random.uniform(0, 10), random.uniform(0, 10), random.uniform(1, 10)), random.vector().normalized()});
  }
  ArenaBlock arena(8 * kMiB);
  const ClusteredScan scan = clustered(surface, *arena);
  EXPECT_EQ(scan.clustering.points[PointClass::kNoise], surface.size() - on_sheet);
}

TEST(Clustering, SetsRadiiOfDiscsThatHoldTheSupportPoints) {
  Random random(33);
  const Surface surface = sheet({0, 0, 0}, {20, 0, 0}, {0, 20, 0}, 0.2, 0.2, random);
  ArenaBlock arena(8 * kMiB);
  const ClusteredScan scan = clustered(surface, *arena);
  EXPECT_EQ(scan.cloud.support_points, kCleanSupport);
  EXPECT_LT(scan.clustering.noise, 1e-4F);
  for (std::uint32_t i = 0; i < scan.cloud.size; ++i) {
    const Vec3f& p = scan.cloud.position[i];
    if (p.head<2>().minCoeff() < 2 || p.head<2>().maxCoeff() > 18) continue;
    const double r = scan.cloud.radius[i];
    EXPECT_NEAR(kPi * r * r / (0.2 * 0.2), scan.cloud.support_points, 0.2 * scan.cloud.support_points);
  }
}

TEST(Clustering, MeasuresTheNoiseOfAScanAndWidensTheSupports) {
  Random random(34);
  Surface surface = sheet({0, 0, 0}, {20, 0, 0}, {0, 20, 0}, 0.1, 0.3, random);
  for (SurfacePoint& p : surface) p.position[2] += 0.05 * random.normal();
  ArenaBlock arena(8 * kMiB);
  const ClusteredScan scan = clustered(surface, *arena);
  EXPECT_NEAR(scan.clustering.noise, 0.05, 0.01);
  EXPECT_GT(scan.cloud.support_points, 2 * kCleanSupport);
}

/// @returns points of a support of a sphere with few points: epsilon is .7 radii
float support_points_of_a_coarse_sphere(double noise) {
  Random random(36);
  Surface surface = sphere(500, 3, {5, 5, 5});
  for (SurfacePoint& p : surface) p.position += noise * random.normal() * p.normal;
  ArenaBlock arena(8 * kMiB);
  return clustered(surface, *arena).cloud.support_points;
}

TEST(Clustering, WidensTheSupportsOfACoarseScanByItsNoiseAndNotByItsCurvature) {
  EXPECT_EQ(support_points_of_a_coarse_sphere(0), kCleanSupport);
  EXPECT_GT(support_points_of_a_coarse_sphere(0.15), 2 * kCleanSupport);
}

TEST(Clustering, TakesNoMoreThanItsPlan) {
  for (const std::uint32_t points : {500U, 20000U}) {
    ArenaBlock arena(8 * kMiB);
    Cloud cloud = cloud_of(sphere(points, 3, {5, 5, 5}), *arena);
    const KdTree3 tree = sort_by_tree(cloud, *arena);
    const std::size_t used = arena->used();
    arena->reset_peak();
    value_of(cluster(cloud, tree, 0.5F, *arena));
    EXPECT_LE(arena->peak() - used, clustering_bytes(points));
  }
}

TEST(Clustering, ReportsAFullArenaAndReleasesWhatItTook) {
  Random random(35);
  const Surface surface = sheet({0, 0, 0}, {20, 0, 0}, {0, 20, 0}, 0.2, 0.2, random);
  ArenaBlock arena(kMiB);
  Cloud cloud = cloud_of(surface, *arena);
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  ASSERT_TRUE(arena->take_top<std::byte>(arena->available() - 16384, "the rest").has_value());
  const std::size_t used = arena->used();
  const auto result = cluster(cloud, tree, 0.5F, *arena);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_EQ(arena->used(), used);
}

}  // namespace
}  // namespace plumbline
