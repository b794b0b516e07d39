#include "hal/sim/part/deviation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/hal/sim/cured_part.hpp"

namespace plumbline {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::FloatNear;

const Resin kGreyResin{.critical = Dose(3.2), .penetration_mm = 0.12};
const DoseModel kGreyModel{.resin = kGreyResin};
constexpr float kTenthUm = 1e-4F;

double standard_dose(std::uint32_t /*layer*/) { return 8.75; }

/// The light of all of a part's pixels, each by its own integral; layers of 0.05 mm with 8.75 mJ/cm2.
/// @param inside  by column, row and layer
double light_at(const Vec3d& p, int layers, const std::function<bool(int, int, int)>& inside) {
  const auto below = [](double u) { return std::erfc(-u / std::sqrt(2)) / 2; };
  double sum = 0;
  for (int k = std::max(0, static_cast<int>(p[2] / 0.05) - 1); k < std::min(layers, static_cast<int>(p[2] / 0.05) + 60);
       ++k) {
    if (0.05 * (k + 1) < p[2]) continue;
    double share = 0;
    const double x = p[0] / 0.05, y = p[1] / 0.05;
    for (int c = static_cast<int>(x) - 4; c <= x + 4; ++c) {
      for (int r = static_cast<int>(y) - 4; r <= y + 4; ++r) {
        if (!inside(c, r, k)) continue;
        share += (below((c + 1 - x) / 0.5) - below((c - x) / 0.5)) * (below((r + 1 - y) / 0.5) - below((r - y) / 0.5));
      }
    }
    sum += 8.75 * share * std::exp(-(0.05 * (k + 1) - p[2]) / 0.12);
  }
  return sum;
}

/// The first place outwards (or inwards, where it is dark) at which the light crosses 3.2 mJ/cm2, in steps of 0.5 um.
double edge_at(const OrientedPoint& point, int layers, const std::function<bool(int, int, int)>& inside) {
  const auto cured = [&](double way) {
    const Vec3d p = point.at.cast<double>() + way * point.normal.cast<double>();
    return light_at(p, layers, inside) >= 3.2;
  };
  const bool is_cured = cured(0);
  double way = 0;
  while (cured(way) == is_cured && std::abs(way) < 0.6) way += is_cured ? 5e-4 : -5e-4;
  return way;
}

TEST(Deviation, OfASlabHighAboveThePlateIsThatOfTheClosedForm) {
  // A slab from 3 to 5 mm on a post at its corner.
  const auto inside = [](double x, double y, double z) {
    return x > 1 && x < 4 && z < 5 && (z > 3 || (x < 1.5 && y < 0.5));
  };
  const CuredPart part = part_of(100, 60, 100, kGreyResin, standard_dose, inside);
  std::vector<OrientedPoint> under, top;
  for (float x = 2.2F; x < 3.5F; x += 0.31F) {
    under.push_back({{x, 2, 3}, -Vec3f::UnitZ()});
    top.push_back({{x, 2, 5}, Vec3f::UnitZ()});
  }
  const auto fade = std::exp(-0.05 / 0.12);
  const auto deep = static_cast<float>(0.12 * std::log(8.75 / 3.2 / (1 - fade)) - 0.05);
  EXPECT_NEAR(deep, 0.200, 0.0005);
  EXPECT_THAT(deviations_mm(part, kGreyModel, under), Each(FloatNear(deep, kTenthUm)));
  EXPECT_THAT(deviations_mm(part, kGreyModel, top), Each(FloatNear(0, kTenthUm)));
  DoseModel exchange = kGreyModel;
  exchange.resin.exchange = 1;
  const auto single = static_cast<float>(0.12 * std::log(8.75 / 3.2) - 0.05);
  EXPECT_THAT(deviations_mm(part, exchange, under), Each(FloatNear(single, kTenthUm)));
  // A wall at a film: the share of light that cures there is Ec (1 - fade) / E, of a normal distribution of 25 um.
  const std::vector<OrientedPoint> wall = {{{4, 1.5F, 3.9999F}, Vec3f::UnitX()}};
  const auto outwards = static_cast<double>(deviations_mm(part, kGreyModel, wall)[0]);
  EXPECT_NEAR(std::erfc(outwards / 0.025 / std::sqrt(2)) / 2, 3.2 * (1 - fade) / 8.75, 1e-3);
}

TEST(Deviation, OfAWedgeAndABallIsThatOfTheSumOverTheirPixels) {
  // Below 45 degrees, with the edge of a layer's mask a pixel further than that of the layer below.
  const auto wedge = [](double x, double y, double z) { return y > 0.5 && y < 2.5 && x > z - 0.02 && x < 4; };
  const auto ball = [](double x, double y, double z) {
    const double dx = x - 2.5, dy = y - 1.5, dz = z - 2.2;
    return dx * dx + dy * dy + dz * dz < 1.2 * 1.2 || (dx * dx + dy * dy < 0.04 && z < 2.2);
  };
  std::vector<OrientedPoint> on_wedge, on_ball;
  const float half = std::sqrt(0.5F);
  for (int i = 0; i < 12; ++i) {
    const float at = 1.0F + 0.137F * static_cast<float>(i);
    on_wedge.push_back({{at, 1.5F, at + 0.02F}, {-half, 0, half}});
    const float up = -0.95F + 0.17F * static_cast<float>(i), turn = 0.7F * static_cast<float>(i);
    const float across = std::sqrt(std::max(0.0F, 1 - up * up));
    const Vec3f normal(across * std::cos(turn), across * std::sin(turn), up);
    on_ball.push_back({Vec3f(2.5F, 1.5F, 2.2F) + 1.2F * normal, normal});
  }
  const auto expect = [](const auto& shape, const std::vector<OrientedPoint>& points) {
    const CuredPart part = part_of(100, 60, 80, kGreyResin, standard_dose, shape);
    const auto found = deviations_mm(part, kGreyModel, points);
    const auto pixels = [&](int c, int r, int k) {
      return shape((c + 0.5) * 0.05, (r + 0.5) * 0.05, (k + 0.5) * 0.05);
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(static_cast<double>(found[i]), edge_at(points[i], 80, pixels), 1e-3) << i;
    }
  };
  expect(wedge, on_wedge);
  expect(ball, on_ball);
}

TEST(Deviation, OfABallsUndersideIsThatOfAFlatOneTimesTheCosine) {
  // A ball of 3 mm on a post. Light falls straight, so the normal distance is the depth, 0.2 mm, times the cosine of the slope.
  const auto inside = [](double x, double y, double z) {
    const double dx = x - 3.51, dy = y - 3.52, dz = z - 4.013;
    return dx * dx + dy * dy + dz * dz < 9 || (dx * dx + dy * dy < 0.04 && z < 4);
  };
  const CuredPart part = part_of(140, 140, 145, kGreyResin, standard_dose, inside);
  std::vector<OrientedPoint> cap;
  for (int i = 0; i < 4000; ++i) {
    const double up = -1 + 0.134 * (i + 0.5) / 4000, turn = 2.399963 * i;
    const double across = std::sqrt(1 - up * up);
    if (across * 3 < 0.9) continue;  // the post's
    const Vec3d normal(across * std::cos(turn), across * std::sin(turn), up);
    cap.push_back({(Vec3d(3.51, 3.52, 4.013) + 3 * normal).cast<float>(), normal.cast<float>()});
  }
  const auto found = deviations_mm(part, kGreyModel, cap);
  double mean = 0, expected = 0;
  for (std::size_t i = 0; i < cap.size(); ++i) {
    mean += 1000 * static_cast<double>(found[i]) / static_cast<double>(cap.size());
    expected -= 199.9 * static_cast<double>(cap[i].normal[2]) / static_cast<double>(cap.size());
  }
  EXPECT_NEAR(mean, expected, 2);
}

TEST(Deviation, TellsGapsThatHaveClosedFromWhatIsNotThere) {
  const auto inside = [](double x, double, double z) {
    return x > 1 && x < 4 && (z < 2 || z > 2.1) && (z > 4 || x < 3 || z < 2);
  };
  const auto gap = [&](double x, double y, double z) { return inside(x, y, z) || (x > 1 && x < 1.3); };
  const CuredPart part = part_of(100, 60, 100, kGreyResin, standard_dose, gap);
  const std::vector<OrientedPoint> points = {
      {{2, 1, 2}, Vec3f::UnitZ()}, {{2, 1, 2.1F}, -Vec3f::UnitZ()}, {{3.5F, 1, 3.2F}, Vec3f::UnitZ()}};
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_THAT(deviations_mm(part, kGreyModel, points), ElementsAre(infinity, infinity, -infinity));
}

}  // namespace
}  // namespace plumbline
