#include "slicer/implicit/winding_number.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/slicer/support/winding_field.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// Sum over every point, in double precision. Near a point, WindingTree uses the point's disc instead of its dipole, so
/// this sum is right only at places some spacings away from all points.
double direct_sum(const WindingField& field, const Vec3d& x) {
  const Cloud& cloud = field.scan().cloud;
  double sum = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    const Vec3d d = cloud.position[i].cast<double>() - x;
    const double r = cloud.radius[i];
    const double area = kPi * r * r / field.scan().cloud.support_points;
    sum += area * cloud.normal[i].unpack().cast<double>().dot(d) / (4 * kPi * std::pow(d.norm(), 3));
  }
  return sum;
}

TEST(WindingNumber, IsOneInsideASphereAndZeroOutside) {
  const Vec3d centre(10, 10, 10);
  const WindingField field(sphere(20000, 5, centre));
  Random random(51);
  for (int i = 0; i < 300; ++i) {
    const Vec3d direction = random.vector().normalized();
    EXPECT_NEAR(field.at(centre + random.uniform(0, 4.5) * direction), 1, 0.08);
    EXPECT_NEAR(field.at(centre + random.uniform(5.5, 12) * direction), 0, 0.08);
  }
}

TEST(WindingNumber, IsTheSumOverAllPoints) {
  const Vec3d centre(10, 10, 10);
  Surface surface;
  for (const SurfacePoint& p : sphere(8000, 5, centre)) {
    if (p.normal[0] < 0.3) surface.push_back(p);  // a large hole gives values of all sizes
  }
  append(surface, torus(7, 1.5, centre + Vec3d(0, 0, 4), 0.2, 2));
  const WindingField field(surface);
  Random random(52);
  double mean = 0;
  for (int i = 0; i < 300; ++i) {
    Vec3d x = centre + 0.9 * random.uniform() * 5 * random.vector().normalized();
    if (i % 2 == 0) x = Vec3d(random.uniform(-5, 25), random.uniform(-5, 25), random.uniform(-8, 3.5));
    const double off = std::abs(field.at(x) - direct_sum(field, x));
    EXPECT_LT(off, 0.05) << x.transpose();
    mean += off / 300;
  }
  EXPECT_LT(mean, 0.01);
}

/// A ball with a large hole, and a plane below it that mirrors it.
TEST(WindingNumber, OfAColumnIsThatOfTheTree) {
  const Vec3d centre(10, 10, 4);
  Surface surface;
  for (const SurfacePoint& p : sphere(20000, 5, centre)) {
    if (p.normal[0] < 0.6) surface.push_back(p);
  }
  WindingField field(surface);
  for (const bool has_base : {false, true}) {
    if (has_base) field->set_base(0.5F, 0.5F, true);
    ColumnWinding column = field.column(13, 10, 0.4F);
    ColumnWinding other = field.column(13, 10, 0.4F);
    Random random(54);
    double mean = 0;
    int other_side = 0;
    std::vector<std::pair<Vec3f, float>> asked;
    for (int i = 0; i < 2000; ++i) {  // in more cells than there is room for
      const Vec3f x =
          Vec3d(random.uniform(12.6, 13.4), random.uniform(9.6, 10.4), random.uniform(-9, 90)).cast<float>();
      asked.emplace_back(x, column(x));
      const double off = std::abs(column(x) - (*field)(x));
      EXPECT_LT(off, 0.03) << x.transpose();
      mean += off / 2000;
      other_side += column.inside(x) != (*field).inside(x) ? 1 : 0;
    }
    EXPECT_LT(mean, 0.002);
    EXPECT_LT(other_side, 10);
    std::reverse(asked.begin(), asked.end());
    for (const auto& [x, winding] : asked) EXPECT_EQ(other(x), winding) << "the order of the questions matters";
  }
}

TEST(WindingNumber, RoughlyTellsWhatIsFarFromOneHalf) {
  const Vec3d centre(10, 10, 10);
  Surface surface;
  for (const SurfacePoint& p : sphere(8000, 5, centre)) {
    if (p.normal[0] < 0.3) surface.push_back(p);
  }
  WindingField field(surface);
  ColumnWinding column = field.column(0, 0, 0.4F);
  Random random(55);
  int rough = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3d at(random.uniform(5, 15), random.uniform(5, 15), 0);
    const Vec2f corner(static_cast<float>(at[0]), static_cast<float>(at[1]));
    column.begin(corner, corner + Vec2f::Constant(0.8F));
    for (int k = 0; k < 12; ++k) {
      const Vec3d place(at[0], at[1], random.uniform(4, 16));
      const Vec3f x = place.cast<float>();
      const float exact = (*field)(x);
      // No point is asked about nearer to the surface than a support radius.
      if (std::abs((place - centre).norm() - 5) > 0.5) {
        EXPECT_NEAR((*field).rough(x), exact, WindingTree::kRough);
      }
      const float told = column.beyond(x, 0.2F);
      rough += told != exact && told == (*field).rough(x) ? 1 : 0;
      if (std::abs(told - 0.5F) <= 0.25F) continue;
      EXPECT_GT(std::abs(exact - 0.5F), 0.2F - 0.03F) << place.transpose();
      EXPECT_EQ(told > 0.5F, exact > 0.5F) << place.transpose();
    }
  }
  EXPECT_GT(rough, 1000) << "the rough number is not used";
}

TEST(WindingNumber, IsOneHalfOnTheSurfaceAndBoundedAtAPoint) {
  const Vec3d centre(10, 10, 10);
  const Surface surface = sphere(20000, 5, centre);
  const WindingField field(surface);
  for (std::size_t i = 0; i < surface.size(); i += 100) EXPECT_NEAR(field.at(surface[i].position), 0.5, 0.1);
}

Surface upper_half(const Surface& surface, double height) {
  Surface half;
  for (const SurfacePoint& p : surface) {
    if (p.position[2] >= height) half.push_back(p);
  }
  return half;
}

TEST(WindingNumber, OfAnOpenHemisphereIsOneInsideOnceTheBaseClosesIt) {
  const Vec3d centre(10, 10, 0);
  WindingField field(upper_half(sphere(30000, 5, centre), 0));
  const Vec3d inside(10, 10, 1);
  EXPECT_LT(field.at(inside), 0.65);
  field->set_base(0, 0.25F);
  Random random(53);
  for (int i = 0; i < 200; ++i) {
    Vec3d direction = random.vector().normalized();
    direction[2] = std::abs(direction[2]);
    EXPECT_NEAR(field.at(centre + random.uniform(0, 4.4) * direction), 1, 0.1);
    EXPECT_NEAR(field.at(centre + random.uniform(5.6, 12) * direction), 0, 0.1);
    EXPECT_EQ(field.at(centre - random.uniform(0.001, 5) * direction.cwiseMax(1e-3)), 0) << "below the base";
  }
}

TEST(WindingNumber, OfAClosedSphereOnThePlaneDoesNotChangeWithTheBase) {
  const Vec3d centre(10, 10, 5);
  WindingField field(sphere(20000, 5, centre));
  Random random(54);
  std::vector<Vec3d> places;
  std::vector<double> before;
  for (int i = 0; i < 200; ++i) {
    const Vec3d place{random.uniform(2, 18), random.uniform(2, 18), random.uniform(0.3, 13)};  // braces: in this order
    places.push_back(place);
    before.push_back(field.at(place));
  }
  field->set_base(0, 0.25F);
  for (std::size_t i = 0; i < places.size(); ++i) EXPECT_NEAR(field.at(places[i]), before[i], 0.06);
}

// A hole in a scanned underside once made the whole underside count as open. It was then closed at the height of the
// lowest outliers.
TEST(WindingNumber, HasABaseForAnOpenUndersideAndNotForAHoleInIt) {
  Random random(55);
  const Surface whole = box({0, 0, 0}, {20, 20, 10}, 0.3, 0.3, random);
  const auto without_disc = [&](double radius) {
    Surface open;
    for (const SurfacePoint& p : whole) {
      if (p.position[2] > 0.1 || std::hypot(p.position[0] - 10, p.position[1] - 10) > radius) open.push_back(p);
    }
    return open;
  };
  constexpr float kStrayDepth = 1.5F;
  EXPECT_FALSE(WindingField(whole)->set_base(-kStrayDepth, 0.5F));
  EXPECT_FALSE(WindingField(without_disc(2))->set_base(-kStrayDepth, 0.5F));
  EXPECT_TRUE(WindingField(without_disc(2))->set_base(-kStrayDepth, 0.5F, true)) << "asked for";
  EXPECT_TRUE(WindingField(without_disc(20))->set_base(0, 0.5F));
}

/// Height at which the vertical line through the middle of a hole passes the surface that closes the hole, mm.
double closed_at(const Surface& surface, const Vec3d& middle) {
  WindingField field(surface);
  const Vec3f place = middle.cast<float>();
  return field.column(place[0], place[1], 0.2F)
      .surface_between(place[0], place[1], place[2] - 2, place[2] + 2, (*field).inside(place - Vec3f(0, 0, 2)), 0.001F);
}

/// A sphere of 10 mm radius, or a hollow of that size in a larger one, without the cap within `degrees` of the z axis.
Surface without_cap(double degrees, bool hollow) {
  Surface surface;
  if (hollow) surface = sphere(120000, 20, Vec3d(12, 12, 12));
  for (SurfacePoint p : sphere(60000, 10, Vec3d(12, 12, 12))) {
    if (p.normal[2] > std::cos(degrees * kPi / 180)) continue;
    if (hollow) p.normal = -p.normal;
    surface.push_back(p);
  }
  return surface;
}

TEST(WindingNumber, ClosesAHoleWithTheCurvatureOfItsRim) {
  for (const double degrees : {12.0, 20.0}) {
    const double cap = 10 * (1 - std::cos(degrees * kPi / 180));
    const Vec3d middle(12, 12, 22 - cap);
    EXPECT_NEAR(closed_at(without_cap(degrees, false), middle), 22, 0.4 * cap) << degrees;
    EXPECT_NEAR(closed_at(without_cap(degrees, true), middle), 22, 0.4 * cap) << degrees;
  }
}

TEST(WindingNumber, ClosesAHoleInAPlaneFlat) {
  Random random(55);
  Surface surface;
  for (const SurfacePoint& p : box({4, 4, 4}, {28, 28, 16}, 0.25, 0.2, random)) {
    if ((p.position - Vec3d(16, 16, 16)).norm() > 2) surface.push_back(p);
  }
  EXPECT_NEAR(closed_at(surface, Vec3d(16, 16, 16)), 16, 0.1);
}

TEST(WindingNumber, OfOnePointAndOfNoneIsFinite) {
  ArenaBlock arena(kMiB);
  Cloud one = cloud_of({{Vec3d(1, 1, 1), Vec3d(0, 0, 1)}}, *arena, 0.5F);
  one.support_points = 20;
  std::vector<WindingTree::Node> nodes(WindingTree::nodes_needed(1));
  const WindingTree tree = WindingTree::build(one, nodes);
  EXPECT_TRUE(std::isfinite(tree({1, 1, 1})));
  EXPECT_GT(tree({1, 1, 0.9F}), 0);
  EXPECT_LT(tree({1, 1, 1.1F}), 0);
  const Cloud none = value_of(Cloud::create(0, *arena));
  EXPECT_EQ(WindingTree::build(none, {})({1, 1, 1}), 0);
}

}  // namespace
}  // namespace plumbline
