/// Slices scans whose normals face into the object. The oracle is the same scan with the right normals.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/wrong_normals.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::Combine;
using ::testing::TestParamInfo;
using ::testing::TestWithParam;
using ::testing::Values;
using ::testing::ValuesIn;

enum class Shape : std::uint8_t { kSphere, kTorus, kBox, kCavity, kOpenUnderside };

const char* to_string(Shape shape) {
  switch (shape) {
    case Shape::kSphere: return "Sphere";
    case Shape::kTorus: return "Torus";
    case Shape::kBox: return "Box";
    case Shape::kCavity: return "Cavity";
    case Shape::kOpenUnderside: return "OpenUnderside";
  }
  return "";
}

constexpr double kSpacing = 0.25;  ///< mm

Surface ball(double radius) { return sphere(sphere_points(radius, kSpacing), radius, Vec3d::Zero()); }

Surface inside_out(Surface surface) {
  for (SurfacePoint& p : surface) p.normal = -p.normal;
  return surface;
}

Surface surface_of(Shape shape) {
  Random random(5);
  Surface surface;
  switch (shape) {
    case Shape::kSphere: return ball(8);
    case Shape::kTorus: return torus(8, 3, Vec3d::Zero(), kSpacing, 2);
    case Shape::kBox: return box({0, 0, 0}, {15, 12, 9}, kSpacing, 0.4, random);
    case Shape::kCavity:
      surface = ball(10);
      append(surface, inside_out(ball(5)));
      return surface;
    case Shape::kOpenUnderside:
      surface = ball(10);
      std::erase_if(surface, [](const SurfacePoint& p) { return p.position[2] < -4; });
      return surface;
  }
  return surface;
}

Slicing sliced(const Surface& surface) { return {binary_ply(surface), settings_with_pitch(0.25F), 64 * kMiB}; }

class WronglyOriented : public TestWithParam<std::tuple<Shape, WrongNormals>> {};

TEST_P(WronglyOriented, ScanHasTheVolumeOfTheRightOne) {
  const auto [shape, wrong] = GetParam();
  Random random(8);
  Surface surface = surface_of(shape);
  add_noise(surface, 0.01, 0.05, random);
  const auto view_of = deal_to_views(surface, random);
  const double right = sliced(surface).volume();
  for (int seed = 0; seed < (wrong == WrongNormals::kViewsAtRandom ? 3 : 1); ++seed) {
    const Slicing slicing = sliced(with_wrong_normals(surface, wrong, view_of, random));
    EXPECT_NEAR(slicing.volume(), right, 0.02 * right) << seed;
    EXPECT_EQ(slicing.report().normals.inside_out, wrong == WrongNormals::kAllInward) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Each, WronglyOriented,
                         Combine(Values(Shape::kSphere, Shape::kTorus, Shape::kBox, Shape::kCavity,
                                        Shape::kOpenUnderside),
                                 ValuesIn(kWrongNormals)),
                         [](const TestParamInfo<WronglyOriented::ParamType>& test) {
                           return std::string(to_string(std::get<0>(test.param))) + to_string(std::get<1>(test.param));
                         });

Surface with_share_turned(Surface surface, double share) {
  Random random(7);
  for (SurfacePoint& p : surface) {
    if (random.uniform() < share) p.normal = -p.normal;
  }
  return surface;
}

TEST(TurnedPoints, OfAnyShareAreTurnedBack) {
  const Surface surface = ball(8);
  const double right = sliced(surface).volume();
  for (const double share : {0.1, 0.25, 0.75, 0.9}) {
    const Slicing slicing = sliced(with_share_turned(surface, share));
    EXPECT_NEAR(slicing.volume(), right, 0.02 * right) << share;
    const auto points = static_cast<double>(surface.size());
    EXPECT_NEAR(slicing.report().normals.turned, share * points, 0.02 * points) << share;
  }
}

// What programs write where they have no normals, or in the wrong order.
TEST(NormalsOfAnythingButTheSurface, AreEstimatedAnew) {
  const Surface surface = ball(8);
  const double right = sliced(surface).volume();
  const auto with = [&](auto normal_of) {
    Surface changed = surface;
    for (SurfacePoint& p : changed) p.normal = normal_of(p);
    return sliced(changed);
  };
  const Vec3d scanner(0, 10, 60);
  for (const Slicing& slicing :
       {with([](const SurfacePoint&) { return Vec3d(0, 0, 1); }),
        with([&](const SurfacePoint& p) { return (scanner - p.position).normalized(); }),
        with([](const SurfacePoint& p) { return Vec3d(p.normal[1], p.normal[2], p.normal[0]); })}) {
    EXPECT_NEAR(slicing.volume(), right, 0.02 * right);
    EXPECT_GT(slicing.report().normals.estimated, surface.size() / 2);
  }
}

// No normal has a component along the way to a neighbour, so none faces another and none faces away.
TEST(TurnedPoints, OfExactPlanesAreTurnedBack) {
  Random random(3);
  const Surface surface = box({0, 0, 0}, {12, 10, 8}, kSpacing, 0, random);
  const Slicing slicing = sliced(with_share_turned(surface, 0.5));
  EXPECT_TRUE(slicing.report().normals.contradictory);
  EXPECT_NEAR(slicing.volume(), 960, 0.02 * 960);
}

TEST(TurnedPoints, AreTurnedBackWhereManyShareACell) {
  const Surface surface = sphere(sphere_points(8, 0.1), 8, Vec3d::Zero());
  const auto coarse = [](const Surface& scan) {
    return Slicing(binary_ply(scan), settings_with_pitch(0.4F), 64 * kMiB);
  };
  const Slicing right = coarse(surface);
  ASSERT_GT(right.report().averaged_points, right.report().cloud_points);
  EXPECT_NEAR(coarse(with_share_turned(surface, 0.5)).volume(), right.volume(), 0.02 * right.volume());
}

// The table is the larger sheet, and encloses nothing by itself.
TEST(InsideOut, IsAlsoFoundIfTheObjectStandsOnATable) {
  Random random(4);
  Surface scan = ball(8);
  std::erase_if(scan, [](const SurfacePoint& p) { return p.position[2] < -6; });
  append(scan, sheet({-20, -20, -6}, {40, 0, 0}, {0, 40, 0}, kSpacing, 0.3, random));
  const double right = sliced(scan).volume();
  ASSERT_GT(right, 1500);
  EXPECT_NEAR(sliced(inside_out(scan)).volume(), right, 0.02 * right);
}

}  // namespace
}  // namespace plumbline
