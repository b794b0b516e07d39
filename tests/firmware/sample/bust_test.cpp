#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "firmware/sample/analytic_bust.hpp"

namespace plumbline::firmware {
namespace {

class Dice {
 public:
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  Vec3d in(const Box3d& box) {
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = (*this)(box.low[axis], box.high[axis]);
    return p;
  }

 private:
  std::mt19937_64 bits_{7};
};

/// Points of the surface: bisection between an inner and an outer point.
std::vector<Vec3d> surface_points(std::size_t count) {
  Dice dice;
  std::vector<Vec3d> points;
  while (points.size() < count) {
    Vec3d inner = dice.in(bust_bounds());
    Vec3d outer = inner + Vec3d{dice(-8, 8), dice(-8, 8), dice(-8, 8)};
    if (!bust_inside(inner) || bust_inside(outer)) continue;
    for (int i = 0; i < 50; ++i) {
      const Vec3d middle = 0.5 * (inner + outer);
      (bust_inside(middle) ? inner : outer) = middle;
    }
    points.push_back(inner);
  }
  return points;
}

TEST(Bust, NeverOverestimatesTheDistanceToItsSurface) {
  const auto surface = surface_points(20000);
  Dice dice;
  Box3d box = bust_bounds();
  box.low -= Vec3d::Constant(5);
  box.high += Vec3d::Constant(5);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d p = dice.in(box);
    const double claimed = bust_distance(p);
    if (claimed <= 0) continue;
    for (const Vec3d& s : surface) ASSERT_LE(claimed, (s - p).norm()) << p.transpose();
  }
}

TEST(Bust, NeverOverestimatesTheDistanceCloseToItsSurface) {
  Dice dice;
  for (const Vec3d& s : surface_points(20000)) {
    const Vec3d p = s + Vec3d{dice(-0.3, 0.3), dice(-0.3, 0.3), dice(-0.3, 0.3)};
    ASSERT_LE(bust_distance(p), (s - p).norm() + 1e-9) << p.transpose();
  }
}

TEST(Bust, IsClosed) {
  // Walk right through it: inside and outside alternate, and the far end is outside.
  const Box3d box = bust_bounds();
  for (double x = box.low.x(); x <= box.high.x(); x += 0.9) {
    for (double z = -2; z <= box.high.z(); z += 0.9) {
      EXPECT_FALSE(bust_inside({x, box.low.y() - 1, z}));
      EXPECT_FALSE(bust_inside({x, box.high.y() + 1, z}));
    }
  }
  for (const Vec3d& s : surface_points(5000)) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(s[axis], box.low[axis] - 1e-9);
      EXPECT_LE(s[axis], box.high[axis] + 1e-9);
    }
  }
}

TEST(Bust, IsOneComponent) {
  // Flood the inside on a grid from a point of the neck.
  constexpr int kSide = 160;
  const Box3d box = bust_bounds();
  const double step = 0.45;
  const auto cell = [&](int i, int j, int k) {
    return Vec3d{box.low.x() + (i + 0.5) * step, box.low.y() + (j + 0.5) * step, (k + 0.5) * step};
  };
  std::vector<char> inside(kSide * kSide * kSide, 0);
  const auto index = [](int i, int j, int k) { return static_cast<std::size_t>((k * kSide + j) * kSide + i); };
  std::size_t all = 0;
  for (int k = 0; k < kSide; ++k) {
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        inside[index(i, j, k)] = bust_inside(cell(i, j, k)) ? 1 : 0;
        all += inside[index(i, j, k)] != 0 ? 1U : 0U;
      }
    }
  }
  std::vector<std::array<int, 3>> open{
      {static_cast<int>(-box.low.x() / step), static_cast<int>((2 - box.low.y()) / step), static_cast<int>(34 / step)}};
  ASSERT_EQ(inside[index(open[0][0], open[0][1], open[0][2])], 1);
  inside[index(open[0][0], open[0][1], open[0][2])] = 2;
  std::size_t reached = 1;
  while (!open.empty()) {
    const auto at = open.back();
    open.pop_back();
    for (int n = 0; n < 6; ++n) {
      auto to = at;
      to[static_cast<std::size_t>(n / 2)] += n % 2 == 0 ? 1 : -1;
      if (to[0] < 0 || to[1] < 0 || to[2] < 0 || to[0] >= kSide || to[1] >= kSide || to[2] >= kSide) continue;
      char& state = inside[index(to[0], to[1], to[2])];
      if (state != 1) continue;
      state = 2;
      ++reached;
      open.push_back(to);
    }
  }
  EXPECT_EQ(reached, all);
  EXPECT_GT(all, 150000U);  // some 17 cubic centimetres, in cubes of 0.45 mm
}

TEST(Bust, IsFlatBelowAtHeightZero) {
  int under_the_plinth = 0;
  for (double x = -20; x <= 20; x += 0.37) {
    for (double y = -16; y <= 18; y += 0.37) {
      EXPECT_FALSE(bust_inside({x, y, 0.0}));
      EXPECT_FALSE(bust_inside({x, y, -1e-6}));
      under_the_plinth += bust_inside({x, y, 1e-6}) ? 1 : 0;
    }
  }
  const double area = under_the_plinth * 0.37 * 0.37;
  EXPECT_NEAR(area, 3.14159265 * 15 * 15, 15);  // the plinth's disc of 15 mm, with a sharp edge at the bottom
}

TEST(Bust, IsSixtyMillimetresTallAndFortyWide) {
  Box3d box;
  for (const Vec3d& s : surface_points(40000)) box.extend(s);
  EXPECT_NEAR(box.size().z(), 59.2, 0.6);
  EXPECT_NEAR(box.size().x(), 39.8, 0.6);
  EXPECT_NEAR(box.size().y(), 30.0, 0.6);
}

TEST(Bust, OverhangsUnderItsNoseChinAndKnot) {
  // Solid with air below: it needs supports.
  const auto overhangs = [](double x, double y, double low, double high) {
    for (double z = low; z < high; z += 0.05) {
      if (!bust_inside({x, y, z}) && bust_inside({x, y, z + 0.05})) return true;
    }
    return false;
  };
  // The head is turned by 13.7 degrees about (0, 1.5).
  const auto turned = [](double y) { return Vec3d{0.2366 * (y - 1.5), 1.5 + 0.9716 * (y - 1.5), 0}; };
  EXPECT_TRUE(overhangs(turned(-11).x(), turned(-11).y(), 38, 45));
  EXPECT_TRUE(overhangs(turned(-8).x(), turned(-8).y(), 30, 37));
  EXPECT_TRUE(overhangs(turned(14).x(), turned(14).y(), 38, 50));
}

}  // namespace
}  // namespace plumbline::firmware
