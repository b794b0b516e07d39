#include "slicer/rays/intersections.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "slicer/rays/grid_width.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A surface sampled and clustered, ready for rays.
class RayLaboratory {
 public:
  explicit RayLaboratory(const Surface& surface)
      : arena_(surface.size() * 120 + 4 * kMiB), scan_(clustered(surface, *arena_)) {
    width_ = grid_width(scan_.cloud, scan_.tree);
    if (width_ <= 0) width_ = scan_.clustering.epsilon;
    gatherer_ = value_of(RayGatherer::create(scan_.cloud, scan_.tree, scan_.cloud.size, scan_.widths(), *arena_));
    solver_ = RaySolver(width_);
  }
  RayLaboratory(const RayLaboratory&) = delete;
  RayLaboratory& operator=(const RayLaboratory&) = delete;

  RaySurface shoot(double x, double y) { return solver_.solve(gatherer_, gather(x, y)); }
  std::optional<float> shoot_near(double x, double y, float depth, bool entering) {
    const Vec2f at(static_cast<float>(x), static_cast<float>(y));
    gatherer_.gather(at, at);
    return solver_.solve_near(gatherer_.points_near(at[0], at[1], depth), depth, entering, 0.4F);
  }
  const RayPoints& gather(double x, double y) {
    const Vec2f at(static_cast<float>(x), static_cast<float>(y));
    gatherer_.gather(at, at);
    return gatherer_.points_of_ray(at[0], at[1]);
  }
  float width() const { return width_; }
  const ClusteredScan& scan() const { return scan_; }

 private:
  ArenaBlock arena_;
  ClusteredScan scan_;
  RayGatherer gatherer_;
  RaySolver solver_;
  float width_ = 0;
};

/// Where the upward ray at (x, y) meets a surface given by a formula.
struct Meeting {
  double depth;
  Vec3d normal;
};
using ExactRay = std::function<std::vector<Meeting>(double x, double y)>;

struct Deviation {
  double mean_depth = 0;   ///< mm
  double worst_depth = 0;  ///< mm
  int meetings = 0;
};

/// Shoots random rays over a square and compares those that graze no surface: every |n_z| is above 0.35.
Deviation deviation_from(const ExactRay& exact, RayLaboratory& laboratory, double low, double high) {
  Random random(77);
  Deviation sum;
  for (int ray = 0; ray < 400; ++ray) {
    const double x = random.uniform(low, high);
    const double y = random.uniform(low, high);
    const std::vector<Meeting> wanted = exact(x, y);
    bool grazing = false;
    for (const Meeting& m : wanted) grazing |= std::abs(m.normal[2]) < 0.35;
    if (wanted.empty() || grazing) continue;
    const RaySurface found = laboratory.shoot(x, y);
    EXPECT_EQ(found.intersections.size(), wanted.size()) << "ray at " << x << ", " << y;
    if (found.intersections.size() != wanted.size()) continue;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const Intersection& hit = found.intersections[i];
      const double off = std::abs(hit.depth - wanted[i].depth);
      sum.mean_depth += off;
      sum.worst_depth = std::max(sum.worst_depth, off);
      ++sum.meetings;
    }
  }
  EXPECT_GT(sum.meetings, 100);
  sum.mean_depth /= std::max(1, sum.meetings);
  return sum;
}

std::vector<Meeting> exact_sphere(double radius, const Vec3d& centre, double x, double y) {
  const double h2 = radius * radius - (x - centre[0]) * (x - centre[0]) - (y - centre[1]) * (y - centre[1]);
  if (h2 <= 0) return {};
  const double h = std::sqrt(h2);
  const auto at = [&](double z) { return Meeting{z, (Vec3d(x, y, z) - centre) / radius}; };
  return {at(centre[2] - h), at(centre[2] + h)};
}

double torus_value(double ring, double tube, const Vec3d& centre, int axis, const Vec3d& at) {
  const Vec3d p = at - centre;
  const double along = p[axis];
  const double from_axis = std::sqrt(p.squaredNorm() - along * along);
  return std::hypot(from_axis - ring, along) - tube;
}

/// Roots of the torus' implicit function along the ray: finds sign changes in fine steps, then bisects.
std::vector<Meeting> exact_torus(double ring, double tube, const Vec3d& centre, int axis, double x, double y) {
  const auto f = [&](double z) { return torus_value(ring, tube, centre, axis, {x, y, z}); };
  std::vector<Meeting> found;
  const double reach = ring + tube + 0.5;
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    double low = centre[2] + reach * (2.0 * i / kSteps - 1);
    double high = centre[2] + reach * (2.0 * (i + 1) / kSteps - 1);
    if ((f(low) > 0) == (f(high) > 0)) continue;
    const bool outside = f(low) > 0;
    for (int k = 0; k < 60; ++k) ((f(0.5 * (low + high)) > 0) == outside ? low : high) = 0.5 * (low + high);
    Vec3d gradient;
    for (int a = 0; a < 3; ++a) {
      Vec3d step = Vec3d::Zero();
      step[a] = 1e-6;
      const Vec3d p(x, y, low);
      gradient[a] = torus_value(ring, tube, centre, axis, p + step) - torus_value(ring, tube, centre, axis, p - step);
    }
    found.push_back({low, gradient.normalized()});
  }
  return found;
}

TEST(Intersections, LieOnThePlane) {
  for (const double tilt : {0.0, 0.3, -1.0}) {
    Random random(41);
    const Vec3d u(12, 0, 12 * tilt);
    const Vec3d v(0, 12, 3);
    const Vec3d n = u.cross(v).normalized();
    RayLaboratory laboratory(sheet({0, 0, 20}, u, v, 0.15, 0.5, random));
    const ExactRay exact = [&](double x, double y) { return std::vector<Meeting>{{20 + x * tilt + y * 0.25, n}}; };
    const Deviation off = deviation_from(exact, laboratory, 1, 11);
    EXPECT_LT(off.worst_depth, 2e-4);
  }
}

TEST(Intersections, OfASphereConvergeAtLeastLinearlyWithTheSpacing) {
  const Vec3d centre(8, 8, 8);
  const double radius = 5;
  const ExactRay exact = [&](double x, double y) { return exact_sphere(radius, centre, x, y); };
  Deviation before;
  for (const double spacing : {0.4, 0.2, 0.1}) {
    RayLaboratory laboratory(sphere(sphere_points(radius, spacing), radius, centre));
    const Deviation off = deviation_from(exact, laboratory, 3, 13);
    EXPECT_LT(off.worst_depth, 0.1 * spacing);
    if (before.meetings > 0) {
      EXPECT_LT(off.mean_depth, 0.5 * before.mean_depth) << spacing;
      EXPECT_LT(off.worst_depth, 0.5 * before.worst_depth) << spacing;
    }
    before = off;
  }
}

TEST(Intersections, OfATorusConvergeAtLeastLinearlyWithTheSpacing) {
  const Vec3d centre(9, 9, 9);
  for (const int axis : {2, 0}) {
    const ExactRay exact = [&](double x, double y) { return exact_torus(5, 2, centre, axis, x, y); };
    Deviation before;
    for (const double spacing : {0.3, 0.15}) {
      RayLaboratory laboratory(torus(5, 2, centre, spacing, axis));
      const Deviation off = deviation_from(exact, laboratory, 2, 16);
      EXPECT_LT(off.worst_depth, 0.25 * spacing);
      if (before.meetings > 0) {
        EXPECT_LT(off.mean_depth, 0.5 * before.mean_depth) << "axis " << axis;
        EXPECT_LT(off.worst_depth, 0.5 * before.worst_depth) << "axis " << axis;
      }
      before = off;
    }
  }
}

TEST(Intersections, AreTheSameFromANearbyDepthButNotInTheOtherDirection) {
  const Vec3d centre(8, 8, 8);
  RayLaboratory laboratory(sphere(sphere_points(5, 0.2), 5, centre));
  Random random(42);
  for (int i = 0; i < 100; ++i) {
    const double angle = random.uniform(0, 2 * kPi);
    const double from_axis = random.uniform(0, 4.5);
    const double x = 8 + from_axis * std::cos(angle);
    const double y = 8 + from_axis * std::sin(angle);
    const RaySurface by_points = laboratory.shoot(x, y);
    const std::vector<Intersection> first(by_points.intersections.begin(), by_points.intersections.end());
    for (std::size_t k = 0; k < first.size(); ++k) {
      const bool entering = k % 2 == 0;
      const float depth = first[k].depth + static_cast<float>(random.uniform(-0.05, 0.05));
      const auto near = laboratory.shoot_near(x, y, depth, entering);
      ASSERT_TRUE(near);
      EXPECT_NEAR(*near, first[k].depth, 0.05F * laboratory.width());
      EXPECT_FALSE(laboratory.shoot_near(x, y, depth, !entering));
    }
  }
}

TEST(Intersections, HaveBandsThatAreTheUnionOfTheSupportRadii) {
  RayLaboratory laboratory(sphere(sphere_points(5, 0.3), 5, {8, 8, 8}));
  Random random(43);
  const Cloud& cloud = laboratory.scan().cloud;
  for (int i = 0; i < 50; ++i) {
    const double x = random.uniform(3, 13);
    const double y = random.uniform(3, 13);
    std::vector<std::pair<double, double>> chords;
    for (std::uint32_t p = 0; p < cloud.size; ++p) {
      const double h = std::min(cloud.radius[p], laboratory.scan().widths().usual);
      const double half2 = h * h - std::pow(cloud.position[p][0] - x, 2) - std::pow(cloud.position[p][1] - y, 2);
      if (half2 <= 0) continue;
      chords.emplace_back(cloud.position[p][2] - std::sqrt(half2), cloud.position[p][2] + std::sqrt(half2));
    }
    std::sort(chords.begin(), chords.end());
    std::vector<std::pair<double, double>> bands;
    for (const auto& c : chords) {
      if (bands.empty() || c.first > bands.back().second) {
        bands.push_back(c);
      } else {
        bands.back().second = std::max(bands.back().second, c.second);
      }
    }
    const RaySurface surface = laboratory.shoot(x, y);
    ASSERT_EQ(surface.bands.size(), bands.size());
    for (std::size_t b = 0; b < bands.size(); ++b) {
      EXPECT_NEAR(surface.bands[b].low, bands[b].first, 1e-3);
      EXPECT_NEAR(surface.bands[b].high, bands[b].second, 1e-3);
    }
  }
}

/// The root of the MLS value between two depths, bisected to the precision of a float.
float bisected(const RayPoints& points, float low, float high) {
  const auto f = [&](float z) { return mls_value(points, window(points, z, z), z).distance; };
  const bool outside = f(low) > 0;
  EXPECT_NE(f(high) > 0, outside);
  for (int i = 0; i < 60; ++i) {
    const float middle = 0.5F * (low + high);
    ((f(middle) > 0) == outside ? low : high) = middle;
  }
  return 0.5F * (low + high);
}

/// Calls compare(points, hit) with the ray's points, for both intersections of each ray through a noisy sphere.
/// @returns the grid width, mm
template <class Compare>
float for_each_hit(Compare compare) {
  Random random(44);
  Surface surface = sphere(sphere_points(5, 0.25), 5, {8, 8, 8});
  add_noise(surface, 0.03, 0.1, random);
  RayLaboratory laboratory(surface);
  for (int i = 0; i < 100; ++i) {
    const double angle = random.uniform(0, 2 * kPi);
    const double from_axis = random.uniform(0, 4);
    const double x = 8 + from_axis * std::cos(angle);
    const double y = 8 + from_axis * std::sin(angle);
    const RaySurface found = laboratory.shoot(x, y);
    EXPECT_EQ(found.intersections.size(), 2U);
    const std::vector<Intersection> hits(found.intersections.begin(), found.intersections.end());
    const RayPoints& points = laboratory.gather(x, y);
    for (const Intersection& hit : hits) compare(points, hit);
  }
  return laboratory.width();
}

TEST(Intersections, LieWithinTheIntervalOfTheRoot) {
  float worst = 0;
  const float width = for_each_hit([&](const RayPoints& points, const Intersection& hit) {
    worst = std::max(worst, std::abs(hit.depth - bisected(points, hit.depth - 0.3F, hit.depth + 0.3F)));
  });
  EXPECT_LE(worst, RaySolver::kInterval * width);
}

TEST(Intersections, BesideAVerticalWallAreThoseOfTheTopAndTheBottom) {
  Random random(45);
  const double spacing = 0.15;
  RayLaboratory laboratory(box({2, 2, 2}, {10, 10, 10}, spacing, 0.3, random));
  ASSERT_GT(laboratory.scan().clustering.points[PointClass::kNeutral], 1000U);
  for (const double off : {0.5, 1.0, 2.0, 5.0, 20.0}) {
    for (int i = 0; i < 20; ++i) {
      const double y = random.uniform(3, 9);
      const RaySurface inside = laboratory.shoot(2 + off * spacing, y);
      ASSERT_EQ(inside.intersections.size(), 2U) << off << " spacings inside the wall";
      if (off >= 5) {
        EXPECT_NEAR(inside.intersections[0].depth, 2, 0.01);
        EXPECT_NEAR(inside.intersections[1].depth, 10, 0.01);
      }
      for (const Band& band : laboratory.shoot(2 - off * spacing, y).bands) {
        EXPECT_EQ(band.first, band.last) << off << " spacings outside the wall";
        EXPECT_FALSE(band.inside_at_low);
      }
    }
  }
}

TEST(Intersections, AreAbsentFarFromEveryPoint) {
  RayLaboratory laboratory(sphere(2000, 5, {8, 8, 8}));
  EXPECT_TRUE(laboratory.shoot(40, 40).intersections.empty());
  EXPECT_TRUE(laboratory.shoot(40, 40).bands.empty());
}

}  // namespace
}  // namespace plumbline
