#include "slicer/implicit/mls.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "slicer/rays/ray_points.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// The formula of mls_value() over the whole cloud, in double precision.
struct DirectSum {
  double distance = 0;
  double weight = 0;
  Vec3d normal = Vec3d::Zero();
  double off_centre = 0;
  bool sure = true;  ///< so far from every threshold that rounding doesn't matter

  /// @param reach  largest support radius of the ray's points, mm
  DirectSum(const Cloud& cloud, double max_radius, double reach, const Vec3d& x)
      : cloud_(cloud), max_radius_(max_radius), x_(x) {
    const Sums all = sums([](const Vec3d&) { return 1.0; });
    weight = all.weight;
    if (!(weight > 0)) return;
    normal = all.normals.normalized();
    off_centre = all.offsets.norm() / weight / reach;
    const double agreement = all.normals.norm() / weight;
    const double plain = std::abs(all.distance());
    sure = std::abs(agreement - 0.997) > 1e-4 && agreement > 0.05 && std::abs(plain - 0.25 * reach) > 1e-3;
    Vec3d facing = normal;
    const bool split = agreement < 0.5 && near_face(all, reach, facing);
    sure &= std::abs(agreement - 0.5) > 1e-3;
    const auto likeness = [&](const Vec3d& n) {
      const double t = std::max(0.0, 8 * n.dot(facing) - 7);
      const bool plainly = !split && (agreement >= 0.997 || plain > 0.25 * reach);
      return plainly ? 1.0 : n.dot(facing) > 0 ? t * t + 0.02 : 0;
    };
    distance = sums(likeness).distance();
  }
  /// The distance with equal weights for all normals.
  double plain_distance() const {
    return sums([](const Vec3d&) { return 1.0; }).distance();
  }

 private:
  struct Sums {
    double weight = 0;
    double to_planes = 0;
    Vec3d normals = Vec3d::Zero();
    Vec3d offsets = Vec3d::Zero();
    double distance() const { return 0.5 * (to_planes / weight + normals.dot(offsets) / (weight * weight)); }
  };
  /// Whether the points lie on two faces, and which way the nearer one faces.
  bool near_face(const Sums& all, double reach, Vec3d& facing) {
    const Vec3d from_middle = all.offsets / all.weight;
    const double outwards = (all.normals.dot(from_middle) - all.to_planes) / all.weight;
    const Vec3d side = from_middle.normalized() * (outwards > 0 ? 1 : -1);
    const Sums face = sums([&](const Vec3d& n) {
      const double cosine = n.dot(side);
      return cosine > 0 ? cosine * cosine + 0.02 : 0;
    });
    const double coherent = face.normals.norm() / face.weight;
    sure &= std::abs(std::abs(outwards) - 0.05 * reach) > 1e-4 * reach && std::abs(coherent - 0.85) > 1e-3;
    if (!(std::abs(outwards) > 0.05 * reach && coherent > 0.85)) return false;
    facing = face.normals.normalized();
    return true;
  }
  template <class Likeness>
  Sums sums(Likeness likeness) const {
    Sums s;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      const Vec3d d = x_ - cloud_.position[i].cast<double>();
      const double h = std::min<double>(cloud_.radius[i], max_radius_);
      const double t = 1 - d.squaredNorm() / (h * h);
      if (!(t > 0)) continue;
      const Vec3d n = cloud_.normal[i].unpack().cast<double>();
      const double w = t * t * likeness(n);
      s.weight += w;
      s.to_planes += w * n.dot(d);
      s.normals += w * n;
      s.offsets += w * d;
    }
    return s;
  }
  const Cloud& cloud_;
  double max_radius_;
  Vec3d x_;
};

/// Random points in a cube of 10 mm, with random normals. They form no surface, which the sums don't need.
Surface random_points(std::uint32_t count, Random& random) {
  Surface surface;
  for (std::uint32_t i = 0; i < count; ++i) {
    surface.push_back(
        {Vec3d(random.uniform(0, 10), random.uniform(0, 10), random.uniform(0, 10)), random.vector().normalized()});
  }
  return surface;
}

class MlsOfRandomPoints : public ::testing::Test {
 protected:
  MlsOfRandomPoints() {
    Random random(1);
    cloud_ = cloud_of(random_points(3000, random), *arena_);
    for (float& r : cloud_.radius) r = static_cast<float>(random.uniform(0.2, 1.5));
    tree_.emplace(value_of(KdTree2::build(cloud_.positions(), *arena_, "test")));
    gatherer_ = value_of(RayGatherer::create(cloud_, *tree_, 3000, {kMaxRadius}, *arena_));
  }
  static constexpr float kMaxRadius = 1.2F;  // smaller than some of the radii
  ArenaBlock arena_{kMiB};
  Cloud cloud_;
  std::optional<KdTree2> tree_;
  RayGatherer gatherer_;
};

TEST_F(MlsOfRandomPoints, IsTheSumOverTheWholeCloud) {
  Random random(2);
  for (int tile = 0; tile < 20; ++tile) {
    const Vec2f low(static_cast<float>(random.uniform(-1, 10)), static_cast<float>(random.uniform(-1, 10)));
    const Vec2f high = low + Vec2f(0.35F, 0.35F);
    gatherer_.gather(low, high);
    for (int ray = 0; ray < 10; ++ray) {
      const float x = low[0] + 0.35F * static_cast<float>(random.uniform());
      const float y = low[1] + 0.35F * static_cast<float>(random.uniform());
      const RayPoints& points = gatherer_.points_of_ray(x, y);
      for (int query = 0; query < 10; ++query) {
        const auto z = static_cast<float>(random.uniform(-1, 11));
        const DirectSum direct(cloud_, kMaxRadius, static_cast<double>(points.reach), Vec3d(x, y, z));
        const RayWindow here = window(points, z, z);
        const MlsValue value = mls_value(points, here, z);
        ASSERT_NEAR(value.weight, direct.weight, 1e-4 * (1 + direct.weight));
        // A weight near zero is only as exact as the subtraction that it comes from.
        if (direct.weight < 0.01 || !direct.sure) continue;
        ASSERT_NEAR(value.distance, direct.distance, 2e-4);
        ASSERT_NEAR(off_centre(points, here, z), direct.off_centre, 2e-3);
      }
    }
  }
}

TEST_F(MlsOfRandomPoints, ChangesOnlyByRoundingWithAWiderWindow) {
  gatherer_.gather({5, 5}, {5, 5});
  const RayPoints& points = gatherer_.points_of_ray(5, 5);
  for (float z = 0; z < 10; z += 0.1F) {
    const MlsValue narrow = mls_value(points, window(points, z, z), z);
    const MlsValue whole = mls_value(points, {0, points.size}, z);
    EXPECT_NEAR(narrow.weight, whole.weight, 1e-5);
    EXPECT_NEAR(narrow.distance, whole.distance, 1e-4);
  }
}

TEST_F(MlsOfRandomPoints, HasNoWeightAndNoValueWhereNoPointIsNear) {
  gatherer_.gather({5, 5}, {5, 5});
  const RayPoints& points = gatherer_.points_of_ray(5, 5);
  const MlsValue value = mls_value(points, window(points, 50, 50), 50);
  EXPECT_EQ(value.weight, 0);
  EXPECT_EQ(value.distance, 0);
  EXPECT_EQ(off_centre(points, window(points, 50, 50), 50), 0);
}

// With the weights (1 - t^2)^2, the mean of a half disc lies 16 / (35 pi / 2) of its radius from the straight edge.
TEST(Mls, IsCentredInASheetAndOffCentreAtItsEdge) {
  constexpr float kRadius = 1;
  Random random(3);
  ArenaBlock arena(16 * kMiB);
  const Cloud cloud = cloud_of(sheet({0, 0, 5}, {10, 0, 0}, {0, 10, 0}, 0.05, 0.2, random), *arena, kRadius);
  const KdTree2 tree = value_of(KdTree2::build(cloud.positions(), *arena, "test"));
  RayGatherer gatherer = value_of(RayGatherer::create(cloud, tree, cloud.size, {kRadius}, *arena));
  const auto off_centre_at = [&](float x) {
    gatherer.gather({x, 5}, {x, 5});
    const RayPoints& points = gatherer.points_of_ray(x, 5);
    return off_centre(points, window(points, 5, 5), 5);
  };
  EXPECT_NEAR(off_centre_at(5), 0, 0.02);
  EXPECT_NEAR(off_centre_at(0), 0.291, 0.02);
  EXPECT_GT(off_centre_at(-0.4F), 0.5F);
}

TEST_F(MlsOfRandomPoints, SortsThePointsOfARayByDepth) {
  gatherer_.gather({3, 4}, {3.5F, 4.5F});
  const RayPoints& points = gatherer_.points_of_ray(3.2F, 4.1F);
  std::uint32_t expected = 0;
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    const double r = std::min(cloud_.radius[i], kMaxRadius);
    expected += std::hypot(cloud_.position[i][0] - 3.2, cloud_.position[i][1] - 4.1) < r ? 1 : 0;
  }
  EXPECT_EQ(points.size, expected);
  EXPECT_TRUE(std::is_sorted(points.depth, points.depth + points.size));
  EXPECT_FALSE(gatherer_.thinned());
}

TEST_F(MlsOfRandomPoints, TakesAnEvenShareOfTooManyPointsInATile) {
  RayGatherer small = value_of(RayGatherer::create(cloud_, *tree_, 100, {kMaxRadius}, *arena_));
  small.gather({2, 2}, {8, 8});
  EXPECT_TRUE(small.thinned());
  EXPECT_LE(small.tile_points(), 100U);
  EXPECT_GT(small.tile_points(), 50U);
}

TEST(Mls, IsTheDistanceToAPlaneExactly) {
  Random random(3);
  const Vec3d u = Vec3d(10, 1, 2);
  const Vec3d v = Vec3d(-1, 10, -3);
  const Vec3d n = u.cross(v).normalized();
  const Vec3d corner(5, 5, 5);
  ArenaBlock arena(4 * kMiB);
  const Cloud cloud = cloud_of(sheet(corner, u, v, 0.2, 0.5, random), *arena, 0.8F);
  const KdTree2 tree = value_of(KdTree2::build(cloud.positions(), *arena, "test"));
  RayGatherer gatherer = value_of(RayGatherer::create(cloud, tree, cloud.size, {1}, *arena));
  const Vec3d middle = corner + 0.5 * (u + v);
  gatherer.gather(middle.head<2>().cast<float>(), middle.head<2>().cast<float>());
  const RayPoints& points = gatherer.points_of_ray(static_cast<float>(middle[0]), static_cast<float>(middle[1]));
  for (double dz = -0.5; dz <= 0.5; dz += 0.05) {
    const auto z = static_cast<float>(middle[2] + dz);
    EXPECT_NEAR(mls_value(points, window(points, z, z), z).distance, n[2] * dz, 1e-4);
  }
}

TEST(Mls, RoundsAnEdgeMuchLessThanTheSupportRadius) {
  Random random(4);
  const Vec3d corner(5, 5, 5);
  Surface surface = sheet(corner, Vec3d(6, 0, 0), Vec3d(0, 6, 0), 0.1, 0.5, random);  // faces up, ends at x = 11
  for (const auto& p : sheet(Vec3d(11, 5, -1), Vec3d(0, 6, 0), Vec3d(0, 0, 6), 0.1, 0.5, random)) surface.push_back(p);
  ArenaBlock arena(4 * kMiB);
  const Cloud cloud = cloud_of(surface, *arena, 1);
  const KdTree2 tree = value_of(KdTree2::build(cloud.positions(), *arena, "test"));
  RayGatherer gatherer = value_of(RayGatherer::create(cloud, tree, cloud.size, {1}, *arena));
  double error = 0;
  double plain = 0;
  for (double beside = 0.1; beside < 1; beside += 0.1) {
    const Vec3d x(11 - beside, 8, 5);
    gatherer.gather(x.head<2>().cast<float>(), x.head<2>().cast<float>());
    const RayPoints& points = gatherer.points_of_ray(static_cast<float>(x[0]), static_cast<float>(x[1]));
    error += std::abs(static_cast<double>(mls_value(points, window(points, 5, 5), 5).distance)) / 9;
    plain += std::abs(DirectSum(cloud, 1, 1, x).plain_distance()) / 9;
  }
  EXPECT_GT(plain, 0.015);
  EXPECT_LT(error, plain / 3);
}

// The mean of both faces once moved the surface out of the wall, by more than its thickness where supports are wide.
TEST(Mls, IsTheDistanceToTheNearerFaceOfAThinWallOrGap) {
  Random random(5);
  for (const double up : {1.0, -1.0}) {
    Surface surface = sheet({0, 0, 5}, Vec3d(6, 0, 0), Vec3d(0, 6, 0), 0.2, 0.4, random);
    for (SurfacePoint& p : sheet({0, 0, 5.3}, Vec3d(6, 0, 0), Vec3d(0, 6, 0), 0.2, 0.4, random)) surface.push_back(p);
    for (SurfacePoint& p : surface) p.normal[2] = p.position[2] > 5.1 ? up : -up;
    ArenaBlock arena(4 * kMiB);
    const Cloud cloud = cloud_of(surface, *arena, 1);
    const KdTree2 tree = value_of(KdTree2::build(cloud.positions(), *arena, "test"));
    RayGatherer gatherer = value_of(RayGatherer::create(cloud, tree, cloud.size, {1}, *arena));
    gatherer.gather({3.1F, 2.9F}, {3.1F, 2.9F});
    const RayPoints& points = gatherer.points_of_ray(3.1F, 2.9F);
    for (const float z : {4.8F, 4.95F, 5.05F, 5.25F, 5.35F, 5.5F}) {
      const double to_nearer = z < 5.15F ? 5 - z : z - 5.3;
      EXPECT_NEAR(mls_value(points, window(points, z, z), z).distance, up * to_nearer, 0.002) << up << " at " << z;
    }
  }
}

// The two terms of the value have the same error, one outwards and one inwards.
TEST(Mls, HasNoErrorOfTheOrderOfTheCurvatureOfASphere) {
  const double radius = 10;
  const Vec3d centre(12, 12, 12);
  for (const float support : {0.5F, 1.0F, 2.0F}) {
    ArenaBlock arena(32 * kMiB);
    const Cloud cloud = cloud_of(sphere(sphere_points(radius, 0.08), radius, centre), *arena, support);
    const KdTree2 tree = value_of(KdTree2::build(cloud.positions(), *arena, "test"));
    RayGatherer gatherer = value_of(RayGatherer::create(cloud, tree, cloud.size, {support}, *arena));
    gatherer.gather({12, 12}, {12, 12});
    const RayPoints& points = gatherer.points_of_ray(12, 12);
    const float top = 22;
    const double first_order = support * support / (2 * radius) / 4;  // E[t^2] of the weight is h^2 / 4
    EXPECT_LT(std::abs(mls_value(points, window(points, top, top), top).distance), 0.05 * first_order) << support;
  }
}

}  // namespace
}  // namespace plumbline
