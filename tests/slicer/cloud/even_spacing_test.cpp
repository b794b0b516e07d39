/// Points in lines that are farther apart than the points of a line, as of sections, laser lines and turntables.

#include "slicer/cloud/even_spacing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace even_spacing_test {

using namespace testing;

constexpr double kRadius = 10;
constexpr double kBall = 4.0 / 3 * kPi * kRadius * kRadius * kRadius;
constexpr double kGap = 0.8;

/// Sections of a ball by planes kGap apart, perpendicular to an axis, without normals.
/// @param noise  standard deviation in the plane, in spacings
Surface sections(double ratio, double noise, int axis) {
  Random random(7);
  Surface surface;
  const double spacing = kGap / ratio;
  for (double height = -kRadius + 0.37 * kGap; height < kRadius; height += kGap) {
    const double r = std::sqrt(kRadius * kRadius - height * height);
    const auto count = static_cast<int>(2 * kPi * r / spacing) + 1;
    const double turned = random.uniform(0, 1);
    for (int i = 0; i < count; ++i) {
      const double a = 2 * kPi * (i + turned) / count;
      Vec3d p;
      p[axis] = height;
      p[(axis + 1) % 3] = r * std::cos(a) + noise * spacing * random.normal();
      p[(axis + 2) % 3] = r * std::sin(a) + noise * spacing * random.normal();
      surface.push_back({p, Vec3d::Zero()});
    }
  }
  return surface;
}

TEST(EvenSpacing, OfSectionsKeepsTheVolume) {
  for (const int axis : {0, 2}) {
    for (const double ratio : {4.0, 10.0, 20.0}) {
      for (const double noise : {0.0, 2.0}) {
        const Slicing sliced(binary_ply(sections(ratio, noise, axis)), settings_with_pitch(0.4F), 64 * kMiB);
        EXPECT_NEAR(sliced.volume() / kBall, 1, 0.01) << axis << ' ' << ratio << ' ' << noise;
      }
    }
  }
}

std::uint32_t averaged_in(const Surface& surface, Cloud& cloud, Arena& arena) {
  cloud = cloud_of(surface, arena);
  const KdTree3 tree = sort_by_tree(cloud, arena);
  return even_out_lines(cloud, tree);
}

TEST(EvenSpacing, LeavesScansWithoutLinesAsTheyAre) {
  Random random(3);
  for (const Surface& surface : {sphere(3000, 10, {0, 0, 0}), box({0, 0, 0}, {20, 16, 12}, 0.5, 0.4, random),
                                 torus(10, 4, {0, 0, 4}, 0.5, 2), sections(3, 0, 2)}) {
    ArenaBlock arena(16 * kMiB);
    Cloud cloud;
    EXPECT_EQ(averaged_in(surface, cloud, *arena), 0U);
    EXPECT_EQ(cloud.size, surface.size());
  }
}

TEST(EvenSpacing, AveragesNormalsAndAddsWeights) {
  Surface surface = sections(20, 0, 2);
  for (SurfacePoint& p : surface) p.normal = p.position.normalized();
  ArenaBlock arena(16 * kMiB);
  Cloud cloud;
  const std::uint32_t averaged = averaged_in(surface, cloud, *arena);
  EXPECT_EQ(averaged + cloud.size, surface.size());
  EXPECT_LT(cloud.size, surface.size() / 3);
  std::uint32_t weight = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    const Vec3f p = cloud.position[i];
    EXPECT_NEAR(std::sqrt(p.squaredNorm()), kRadius, 0.01);
    EXPECT_GT(cloud.normal[i].unpack().dot(p), 0.9999F * std::sqrt(p.squaredNorm()));
    weight += cloud.normal[i].weight;
  }
  EXPECT_EQ(weight, surface.size());
}

}  // namespace even_spacing_test
}  // namespace plumbline
