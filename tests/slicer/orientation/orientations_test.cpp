#include "slicer/orientation/orientations.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "slicer/placement/placement.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kSpacing = 0.4;

Surface turned(Surface surface, const Vec3d& degrees) {
  const Mat3d rotation = rotation_matrix(degrees);
  for (SurfacePoint& p : surface) p = {rotation * p.position, rotation * p.normal};
  return surface;
}

const Orientation& cheapest(const WaysUp& ways) {
  return *std::ranges::min_element(ways, {}, [](const Orientation& way) { return way.cost.total; });
}

/// A box that is as high as it is wide twice over, with its underside.
Surface tower(Random& random) { return box({-8, -8, 0}, {8, 8, 30}, kSpacing, 0.3, random); }

/// The patches of a surface, and the memory they are in.
struct Sampled {
  explicit Sampled(const Surface& surface)
      : arena(16 * kMiB), samples(value_of(sample_surface(cloud_of(surface, *arena), *arena))) {}
  ArenaBlock arena;
  SurfaceSamples samples;
};

TEST(SurfaceSamples, HaveTheAreaOfTheSurface) {
  Random random(1);
  EXPECT_NEAR(Sampled(sphere(20000, 10, {3, 4, 5})).samples.area, 4 * kPi * 100, 0.2 * 1257)
      << "cells at the edge count in full";
  const Sampled ball(sphere(20000, 10, {3, 4, 5}));
  EXPECT_LT(ball.samples.hole_share(), 0.01F);
}

TEST(SurfaceSamples, KnowTheHoleOfAnOpenSurface) {
  Random random(2);
  Surface open = tower(random);
  std::erase_if(open, [](const SurfacePoint& p) { return p.normal[2] < -0.5; });
  const Sampled sampled(open);
  EXPECT_NEAR(static_cast<double>(sampled.samples.hole[2]), -256, 40);
  EXPECT_NEAR(static_cast<double>(sampled.samples.hole[0]), 0, 10);
  EXPECT_NEAR(static_cast<double>(sampled.samples.hole[1]), 0, 10);
}

TEST(Orientation, CostsWhatAFormulaSaysOfABall) {
  const Sampled ball(sphere(20000, 10, {0, 0, 0}));
  const OrientationCost cost = cost_of(ball.samples, {30, 40});
  const double scale = 4 * kPi * 100 / static_cast<double>(ball.samples.area);
  // Within 35 degrees of straight down the ball covers pi (r sin 35)^2 of the plate, with the foot.
  const double covered = kPi * 100 * std::pow(std::sin(35 * kPi / 180), 2);
  EXPECT_NEAR(cost.support_area * scale + cost.foot_area * scale, covered, 0.08 * covered);
  EXPECT_NEAR(cost.peel_area * scale, kPi * 100, 0.05 * kPi * 100);
  EXPECT_NEAR(cost.height, 20, 0.5);
}

TEST(Orientation, TheBestWayUpOfABoxIsFlat) {
  Random random(3);
  for (const Vec3d& degrees : {Vec3d(17, 0, 0), Vec3d(-33, 21, 50), Vec3d(8, -71, 120)}) {
    const Sampled box(turned(tower(random), degrees));
    const auto best = best_orientations(box.samples, CleanSide::kNone, {});
    ASSERT_TRUE(best);
    const Mat3d total =
        rotation_matrix({cheapest(*best).degrees[0], cheapest(*best).degrees[1], 0}) * rotation_matrix(degrees);
    // A side of the box points up, to half a degree.
    EXPECT_GT(total.row(2).cwiseAbs().maxCoeff(), std::cos(0.5 * kPi / 180)) << degrees.transpose();
    EXPECT_LT(cheapest(*best).cost.support_area, 0.01 * static_cast<double>(box.samples.area));
  }
}

TEST(Orientation, AHeightIsThatOfTheScanAsItCame) {
  Random random(5);
  const Surface leaning = turned(tower(random), {0, 30, 0});
  Box3d box;
  for (const SurfacePoint& p : leaning) box.extend(p.position);
  SliceSettings settings = settings_with_pitch(0.4F);
  settings.orient = true;
  settings.placement.size = PrintSize{Side::kHeight, 20};
  const Slicing sliced(binary_ply(leaning), settings, 64 * kMiB);
  ASSERT_TRUE(sliced.report().turned);
  EXPECT_NEAR(sliced.report().placement.scale, 20 / box.size()[2], 0.01);
  // Nor does a turn by hand change it, or the unit that is guessed.
  const auto scale_of_turned = [&](const Vec3d& degrees) {
    settings.placement.rotation_degrees = degrees;
    return Slicing(binary_ply(leaning), settings, 64 * kMiB).report().placement.scale;
  };
  settings.orient = false;
  for (const Vec3d& degrees : {Vec3d(0, 0, 0), Vec3d(90, 0, 0), Vec3d(25, -40, 10)}) {
    EXPECT_NEAR(scale_of_turned(degrees), 20 / box.size()[2], 0.01) << degrees.transpose();
  }
  settings.placement.size = PrintSize{Side::kLength, 30};
  EXPECT_NEAR(scale_of_turned({0, -30, 0}), 30 / box.size().maxCoeff(), 0.01);
}

TEST(Orientation, KeepsAFigureUprightWhereThatCostsLittle) {
  // A cylinder with round ends: it needs fewer supports lying, and its face would be on the plate.
  Surface figure = sphere(8000, 6, {0, 0, 0});
  for (SurfacePoint& p : figure) {
    if (p.position[2] > 0) p.position[2] += 10;
  }
  for (int i = 0; i < 12000; ++i) {
    const double angle = 2.399963 * i;
    const Vec3d out(std::cos(angle), std::sin(angle), 0);
    figure.push_back({6 * out + Vec3d(0, 0, 10.0 * i / 12000), out});
  }
  const Sampled sampled(figure);
  const auto best = best_orientations(sampled.samples, CleanSide::kNone, {});
  ASSERT_TRUE(best);
  EXPECT_GT(rotation_matrix({cheapest(*best).degrees[0], cheapest(*best).degrees[1], 0})(2, 2), 0.7);
}

Vec3d up_of(const Orientation& o) { return rotation_matrix({o.degrees[0], o.degrees[1], 0}).row(2).transpose(); }

TEST(Orientation, TheBestDifferFromEachOtherAndFromTheScanAsItCame) {
  Random random(4);
  for (const Surface& surface : {tower(random), sphere(20000, 10, {0, 0, 0}), turned(tower(random), {0, 40, 0})}) {
    const Sampled sampled(surface);
    const auto best = *best_orientations(sampled.samples, CleanSide::kNone, {});
    EXPECT_EQ(best[0].degrees, (std::array<double, 2>{0, 0}));
    for (std::size_t i = 1; i < best.size(); ++i) {
      EXPECT_LT(up_of(best[i])[2], std::cos(19.9 * kPi / 180));
      for (std::size_t k = 1; k < i; ++k) {
        EXPECT_LE(best[k].cost.total, best[i].cost.total);
        EXPECT_LT(up_of(best[k]).dot(up_of(best[i])), std::cos(29 * kPi / 180));
      }
    }
  }
}

TEST(Orientation, AScarOnTheSideThatStaysCleanCostsWhatAFormulaSaysOfABall) {
  const Sampled ball(sphere(20000, 10, {0, 0, 0}));
  const double scale = 4 * kPi * 100 / static_cast<double>(ball.samples.area);
  // The integral of cos^2 over the cap within 35 degrees of straight down, but for the foot in its middle, where the cosine is above 0.97.
  const double cap = 2 * kPi * 100 * (std::pow(0.97, 3) - std::pow(std::cos(35 * kPi / 180), 3)) / 3;
  EXPECT_NEAR(cost_of(ball.samples, {0, 0}, CleanSide::kMinusZ).clean_area * scale, cap, 0.12 * cap);
  EXPECT_NEAR(cost_of(ball.samples, {180, 0}, CleanSide::kMinusZ).clean_area * scale, 0, 1e-3 * cap);
  EXPECT_NEAR(cost_of(ball.samples, {90, 0}, CleanSide::kPlusY).clean_area * scale, 0, 1e-3 * cap) << "its -y is down";
  EXPECT_NEAR(cost_of(ball.samples, {-90, 0}, CleanSide::kPlusY).clean_area * scale, cap, 0.12 * cap);
  EXPECT_EQ(cost_of(ball.samples, {0, 0}).clean_area, 0);
}

TEST(Orientation, KeepsASideCleanThatWouldBeDown) {
  const Sampled ball(sphere(20000, 10, {0, 0, 0}));
  for (const CleanSide side : {CleanSide::kMinusZ, CleanSide::kPlusX, CleanSide::kMinusY}) {
    const auto best = *best_orientations(ball.samples, side, {});
    const OrientationCost& cost = cheapest(best).cost;
    EXPECT_LT(cost.clean_area, 0.2 * cost.support_area) << kCleanSideWords[static_cast<std::size_t>(side)];
  }
}

TEST(CleanSide, HasOneTableOfWords) {
  for (std::size_t i = 0; i < kCleanSideWords.size(); ++i) {
    EXPECT_EQ(clean_side_named(kCleanSideWords[i]), static_cast<CleanSide>(i));
    EXPECT_NE(std::string_view(kCleanSideForm).find(kCleanSideWords[i]), std::string_view::npos);
  }
  EXPECT_FALSE(clean_side_named("y"));
  EXPECT_EQ(facing(CleanSide::kMinusY, {0, -1, 0}), 1);
  EXPECT_EQ(facing(CleanSide::kMinusY, {0, 1, 0}), 0);
  EXPECT_EQ(facing(CleanSide::kPlusX, {1, 0, 0}), 1);
  EXPECT_EQ(facing(CleanSide::kNone, {1, 0, 0}), 0);
}

/// A cone with an open base, on which it should stand.
Surface open_cone() {
  Surface surface;
  const double radius = 10;
  const double height = 25;
  for (double z = 0; z < height; z += kSpacing) {
    const double r = radius * (1 - z / height);
    const auto count = static_cast<int>(2 * kPi * r / kSpacing) + 1;
    for (int i = 0; i < count; ++i) {
      const double a = 2 * kPi * (i + 0.3 * z) / count;
      surface.push_back({Vec3d(r * std::cos(a), r * std::sin(a), z),
                         Vec3d(height * std::cos(a), height * std::sin(a), radius).normalized()});
    }
  }
  return surface;
}

TEST(Upright, StandsUpWhatLiesWrong) {
  const Surface cone = open_cone();
  EXPECT_FALSE(better_upright(Sampled(cone).samples)) << "it stands";
  for (const Vec3d& degrees :
       {Vec3d(90, 0, 0), Vec3d(-90, 0, 0), Vec3d(180, 0, 0), Vec3d(0, 90, 0), Vec3d(0, -90, 0)}) {
    const auto advice = better_upright(Sampled(turned(cone, degrees)).samples);
    ASSERT_TRUE(advice) << degrees.transpose();
    const Mat3d total = rotation_matrix({advice->degrees[0], advice->degrees[1], 0}) * rotation_matrix(degrees);
    EXPECT_NEAR(total(2, 2), 1, 1e-9) << degrees.transpose();
  }
}

TEST(Upright, LeavesBallsAndBoxesAlone) {
  Random random(5);
  EXPECT_FALSE(better_upright(Sampled(sphere(20000, 10, {0, 0, 0})).samples));
  EXPECT_FALSE(better_upright(Sampled(tower(random)).samples));
  EXPECT_FALSE(better_upright(Sampled(turned(tower(random), {90, 0, 0})).samples));
}

}  // namespace
}  // namespace plumbline
