#include "slicer/rays/grid_width.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A flat square lattice. All points are exiting unless a test changes their class.
class LatticeCloud {
 public:
  LatticeCloud(std::uint32_t side, double spacing) : arena_(4 * kMiB) {
    Surface surface;
    for (std::uint32_t j = 0; j < side; ++j) {
      for (std::uint32_t i = 0; i < side; ++i) surface.push_back({spacing * Vec3d(i, j, 0), Vec3d(0, 0, 1)});
    }
    cloud_ = cloud_of(surface, *arena_);
    set_class(PointClass::kExiting);
  }
  void set_class(PointClass to) {
    for (std::uint32_t i = 0; i < cloud_.size; ++i) cloud_.normal[i].point_class = to;
  }
  Cloud& cloud() { return cloud_; }
  float width() {
    const ArenaScope scope(*arena_);
    return grid_width(cloud_, value_of(KdTree2::build(cloud_.positions(), *arena_, "test")));
  }

 private:
  ArenaBlock arena_;
  Cloud cloud_;
};

// An inner point has four neighbours at 1 spacing, four at sqrt(2) and four at 2, so the tenth is at 2. Along the
// border, where one in twenty-five of the 100 x 100 points lies, it is at 2.2 to 3 spacings.
TEST(GridWidth, OnASquareLatticeIsThatOfItsTenthNeighbour) {
  const double spacing = 0.25;
  const std::int32_t side = 100;
  double sum = 0;
  for (std::int32_t j = 0; j < side; ++j) {
    for (std::int32_t i = 0; i < side; ++i) {
      std::vector<double> d;
      for (std::int32_t y = std::max(0, j - 4); y <= std::min(side - 1, j + 4); ++y) {
        for (std::int32_t x = std::max(0, i - 4); x <= std::min(side - 1, i + 4); ++x)
          d.push_back(std::hypot(x - i, y - j));
      }
      std::nth_element(d.begin(), d.begin() + 10, d.end());  // 0 is the point itself
      if (i >= 2 && j >= 2 && i < side - 2 && j < side - 2) {
        ASSERT_EQ(d[10], 2);
      }
      sum += d[10];
    }
  }
  LatticeCloud lattice(side, spacing);
  const double exact = std::sqrt(kPi) * spacing * sum / (side * side);
  EXPECT_NEAR(lattice.width(), exact, 1e-5 * exact);
  EXPECT_NEAR(lattice.width(), std::sqrt(kPi) * 2 * spacing, 0.02 * std::sqrt(kPi) * 2 * spacing);
}

TEST(GridWidth, IsThatOfTheDenserPracticalClass) {
  LatticeCloud lattice(60, 0.5);
  const float whole = lattice.width();
  // Every fourth point is entering, so these are twice as far apart. Neutral points don't count.
  for (std::uint32_t i = 0; i < lattice.cloud().size; ++i) {
    const bool both_even = i % 60 % 2 == 0 && i / 60 % 2 == 0;
    lattice.cloud().normal[i].point_class = both_even ? PointClass::kEntering : PointClass::kNeutral;
  }
  const float quarter = lattice.width();
  EXPECT_NEAR(quarter, 2 * whole, 0.05F * whole);
  for (std::uint32_t i = 0; i < lattice.cloud().size; ++i) {
    PointClass& type = lattice.cloud().normal[i].point_class;
    if (type == PointClass::kNeutral) type = PointClass::kExiting;
  }
  EXPECT_LT(lattice.width(), 0.75F * quarter);
}

TEST(GridWidth, IsZeroIfNoClassHasEnoughPoints) {
  LatticeCloud lattice(20, 0.5);
  lattice.set_class(PointClass::kNeutral);
  EXPECT_EQ(lattice.width(), 0);
  for (std::uint32_t i = 0; i < 10; ++i) lattice.cloud().normal[i].point_class = PointClass::kEntering;
  EXPECT_EQ(lattice.width(), 0) << "ten points have nine neighbours";
  lattice.cloud().normal[10].point_class = PointClass::kEntering;
  EXPECT_GT(lattice.width(), 0);
}

}  // namespace
}  // namespace plumbline
