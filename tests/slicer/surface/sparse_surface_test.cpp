#include "slicer/surface/sparse_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "slicer/surface/refined_normals.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace sparse_surface_test {

using namespace testing;

constexpr double kBore = 0.8;     ///< mm, radius
constexpr double kDepth = 6;      ///< mm
constexpr double kSpacing = 0.6;  ///< mm, on the bore's wall: four times the plate's

/// A plate with a bore whose wall few views saw; normals face the air.
Surface bored_plate(Random& random) {
  Surface surface;
  for (const SurfacePoint& p : sheet({-8, -8, 0}, {16, 0, 0}, {0, 16, 0}, 0.14, 0.3, random)) {
    if (std::hypot(p.position[0], p.position[1]) > kBore) surface.push_back(p);
  }
  for (double z = -kDepth; z < -0.1; z += kSpacing) {
    const int around = static_cast<int>(2 * kPi * kBore / kSpacing);
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * kPi * (k + random.uniform(-0.2, 0.2)) / around;
      const Vec3d inwards(-std::cos(angle), -std::sin(angle), 0);
      surface.push_back({-kBore * inwards + Vec3d(0, 0, z + random.uniform(-0.1, 0.1)), inwards});
    }
  }
  return surface;
}
bool in_bore(const Vec3f& p) { return p[2] < -0.5F && p[2] > -static_cast<float>(kDepth) + 0.5F; }

struct Clustered {
  ArenaBlock block{32 * kMiB};
  Cloud cloud;
  KdTree3 tree;
  ClusteringResult result;

  explicit Clustered(const Surface& surface) : cloud(cloud_of(surface, *block)), tree(sort_by_tree(cloud, *block)) {
    const float epsilon = value_of(density_epsilon(cloud, tree, *block));
    result = value_of(cluster(cloud, tree, epsilon, *block));
  }
  void rescue() {
    std::vector<PackedNormal> refined(cloud.size);
    check(refine_normals(cloud, tree, result, NormalSource::kScanner, refined));
    std::copy(refined.begin(), refined.end(), cloud.normal.begin());
    check(rescue_sparse_surface(cloud, tree, result.epsilon));
  }
  /// Share of the points for which `where` is true that are not noise.
  template <class Where>
  double kept(Where where) const {
    double all = 0;
    double kept = 0;
    for (std::uint32_t i = 0; i < cloud.size; ++i) {
      if (!where(cloud.position[i])) continue;
      ++all;
      kept += cloud.normal[i].point_class != PointClass::kNoise ? 1 : 0;
    }
    return kept / all;
  }
};

// The wall of a narrow bore curves away within few points. Heights over the neighbours' planes alone made it noise.
TEST(SparseSurface, IncludesTheWallOfANarrowBore) {
  Random random(1);
  EXPECT_GT(Clustered(bored_plate(random)).kept(in_bore), 0.8);
}

// The wall of a cup has many points outside and few inside. When the nearest points were all on the outside, the inside
// became noise and the cup was filled.
TEST(SparseSurface, IncludesTheSparseSideOfAThinWall) {
  Random random(4);
  Surface surface = sheet({-8, -8, 0}, {0, 16, 0}, {16, 0, 0}, 0.14, 0.3, random);
  const auto from = static_cast<std::uint32_t>(surface.size());
  append(surface, sheet({-4, -4, 0.7}, {8, 0, 0}, {0, 8, 0}, 0.8, 0.2, random));
  ArenaBlock block(32 * kMiB);
  const Cloud cloud = cloud_of(surface, *block);
  const KdTree3 tree = value_of(KdTree3::build(cloud.positions(), *block, "test"));
  for (std::uint32_t i = from; i < cloud.size; ++i) {
    EXPECT_TRUE(sparse_share(cloud, tree, i, 0.6F).has_value()) << cloud.position[i].transpose();
  }
}

// A few points of a dense sheet face the wrong way. They agree with each other, so each was taken for a sparse sheet, with a support wide
// enough to reach the next.
TEST(SparseSurface, DoesNotIncludePointsThatAreTurnedOver) {
  Random random(5);
  Surface surface = sheet({-8, -8, 0}, {0, 16, 0}, {16, 0, 0}, 0.14, 0.3, random);
  add_noise(surface, 0.03, 0, random);
  std::vector<std::uint32_t> turned;
  for (std::uint32_t i = 0; i < surface.size(); ++i) {
    if (random.uniform() < 0.02) turned.push_back(i);
  }
  for (const std::uint32_t i : turned) surface[i].normal = -surface[i].normal;
  ArenaBlock block(32 * kMiB);
  const Cloud cloud = cloud_of(surface, *block);
  const KdTree3 tree = value_of(KdTree3::build(cloud.positions(), *block, "test"));
  for (const std::uint32_t i : turned) EXPECT_FALSE(sparse_share(cloud, tree, i, 0.6F).has_value());
}

TEST(SparseSurface, LeavesOutPointsBesideIt) {
  Random random(2);
  Surface surface = bored_plate(random);
  const auto from = static_cast<std::uint32_t>(surface.size());
  for (int k = 0; k < 6; ++k) surface.push_back({Vec3d(-kBore + 0.4, 0, -1 - 0.8 * k), Vec3d(1, 0, 0)});
  ArenaBlock block(32 * kMiB);
  const Cloud cloud = cloud_of(surface, *block);
  const KdTree3 tree = value_of(KdTree3::build(cloud.positions(), *block, "test"));
  for (std::uint32_t i = from; i < cloud.size; ++i) {
    EXPECT_FALSE(sparse_share(cloud, tree, i, 0.55F).has_value()) << cloud.position[i].transpose();
  }
}

TEST(SparseSurface, IsRescuedWhereItsNormalsWereWrong) {
  Random random(3);
  Surface surface = bored_plate(random);
  for (SurfacePoint& p : surface) {
    if (p.position[2] < -0.1 && random.uniform() < 0.3) p.normal = random.vector().normalized();
  }
  for (int k = 0; k < 200; ++k) {
    surface.push_back(
        {Vec3d(random.uniform(-8, 8), random.uniform(-8, 8), random.uniform(2, 12)), random.vector().normalized()});
  }
  Clustered scan(surface);
  const auto outlier = [](const Vec3f& p) { return p[2] > 1; };
  const double before = scan.kept(in_bore);
  EXPECT_LT(before, 0.85);
  scan.rescue();
  EXPECT_GT(scan.kept(in_bore), before + 0.1);
  EXPECT_LT(scan.kept(outlier), 0.02);
}

}  // namespace sparse_surface_test
}  // namespace plumbline
