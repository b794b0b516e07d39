#include "slicer/surface/surface_class.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(Orientation, IsNeutralWithinFiveDegreesOfPerpendicular) {
  const auto at = [](double degrees) {
    PackedNormal normal;
    const double a = degrees * kPi / 180;
    normal.set(Vec3d(std::cos(a) * 0.6, std::cos(a) * 0.8, std::sin(a)).cast<float>());
    return orientation_of(normal);
  };
  EXPECT_EQ(at(90), PointClass::kExiting);
  EXPECT_EQ(at(5.02), PointClass::kExiting);
  EXPECT_EQ(at(4.98), PointClass::kNeutral);
  EXPECT_EQ(at(0), PointClass::kNeutral);
  EXPECT_EQ(at(-4.98), PointClass::kNeutral);
  EXPECT_EQ(at(-5.02), PointClass::kEntering);
  EXPECT_EQ(at(-90), PointClass::kEntering);
}

TEST(ClassCounts, CountNoiseApartFromTheSurface) {
  std::vector<PackedNormal> normals(7);
  for (std::size_t i = 0; i < 4; ++i) normals[i].point_class = PointClass::kExiting;
  normals[4].point_class = PointClass::kNeutral;
  const ClassCounts points = count_classes(normals);
  EXPECT_EQ(points[PointClass::kExiting], 4U);
  EXPECT_EQ(points[PointClass::kNeutral], 1U);
  EXPECT_EQ(points[PointClass::kNoise], 2U);
  EXPECT_EQ(points.surface(), 5U);
}

TEST(ClassCounts, CallOneInAThousandNegligible) {
  ClassCounts points;
  points[PointClass::kExiting] = 999;
  points[PointClass::kEntering] = 1;
  points[PointClass::kNoise] = 5000;
  EXPECT_TRUE(points.is_negligible(PointClass::kEntering));
  EXPECT_TRUE(points.is_negligible(PointClass::kNeutral));
  EXPECT_FALSE(points.is_negligible(PointClass::kExiting));
  points[PointClass::kEntering] = 2;
  EXPECT_FALSE(points.is_negligible(PointClass::kEntering));
}

}  // namespace
}  // namespace plumbline
