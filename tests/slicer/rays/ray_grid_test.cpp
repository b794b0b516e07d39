#include "slicer/rays/ray_grid.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/pixels.hpp"
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
  float width(const RayGridSettings& settings = {}) {
    const ArenaScope scope(*arena_);
    return grid_width(cloud_, value_of(KdTree2::build(cloud_.positions(), *arena_, "test")), settings);
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
  RayGridSettings all;
  all.width_sample = 10000;
  LatticeCloud lattice(side, spacing);
  const double exact = std::sqrt(kPi) * spacing * sum / (side * side);
  EXPECT_NEAR(lattice.width(all), exact, 1e-5 * exact);
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

/// All pixels within sqrt(2) w of a point, and all that these enclose.
Pixels interested_by_looking(const Cloud& cloud, const PrintGrid& grid, float width) {
  const auto columns = static_cast<std::int64_t>(grid.columns);
  const auto rows = static_cast<std::int64_t>(grid.rows);
  Pixels passing(grid.columns, grid.rows);
  for (std::uint32_t r = 0; r < grid.rows; ++r) {
    for (std::uint32_t c = 0; c < grid.columns; ++c) {
      for (const Vec3f& p : cloud.positions()) {
        const double dx = (c + 0.5) * static_cast<double>(grid.pitch_x_mm) - static_cast<double>(p[0]);
        const double dy = (r + 0.5) * static_cast<double>(grid.pitch_y_mm) - static_cast<double>(p[1]);
        if (std::hypot(dx, dy) <= std::sqrt(2.0) * static_cast<double>(width)) passing.set(c, r, true);
      }
    }
  }
  Pixels outside(grid.columns + 2, grid.rows + 2);  // with a border all round
  std::vector<std::pair<std::int64_t, std::int64_t>> open{{-1, -1}};
  outside.set(0, 0, true);
  while (!open.empty()) {
    const auto [c, r] = open.back();
    open.pop_back();
    for (const auto& [dc, dr] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
      const std::int64_t x = c + dc;
      const std::int64_t y = r + dr;
      if (x < -1 || y < -1 || x > columns || y > rows || passing.at(x, y) || outside.at(x + 1, y + 1)) continue;
      outside.set(static_cast<std::uint32_t>(x + 1), static_cast<std::uint32_t>(y + 1), true);
      open.emplace_back(x, y);
    }
  }
  Pixels interested(grid.columns, grid.rows);
  for (std::uint32_t r = 0; r < grid.rows; ++r) {
    for (std::uint32_t c = 0; c < grid.columns; ++c) interested.set(c, r, !outside.at(c + 1, r + 1));
  }
  return interested;
}

class InterestedRays : public ::testing::Test {
 protected:
  /// Compares the interested rays with those found by brute force, and returns them.
  Pixels of(const Surface& surface, const PrintGrid& grid, float width) {
    const ArenaScope scope(*arena_);
    const Cloud cloud = cloud_of(surface, *arena_);
    OwnedImage interested(grid.columns, grid.rows);
    check(find_interested_rays(cloud, grid, width, interested.view(), *arena_));
    EXPECT_TRUE(interested.clear_past_the_last_column());
    const Pixels found(interested.view());
    EXPECT_EQ(found, interested_by_looking(cloud, grid, width));
    return found;
  }
  static PrintGrid grid(std::uint32_t columns, std::uint32_t rows, float pitch_x, float pitch_y) {
    PrintGrid grid;
    grid.columns = columns;
    grid.rows = rows;
    grid.layers = 10;
    grid.pitch_x_mm = pitch_x;
    grid.pitch_y_mm = pitch_y;
    return grid;
  }
  ArenaBlock arena_{kMiB};
};

Surface arc(const Vec3d& centre, double radius, double from_degrees, double to_degrees) {
  Surface points;
  for (double a = from_degrees; a <= to_degrees; a += 3) {
    points.push_back({centre + radius * Vec3d(std::cos(a * kPi / 180), std::sin(a * kPi / 180), 0), Vec3d(0, 0, 1)});
  }
  return points;
}

TEST_F(InterestedRays, FillTheInsideOfARing) {
  const Pixels found = of(arc({6.4, 5.1, 0}, 4, 0, 360), grid(130, 110, 0.1F, 0.1F), 0.2F);
  EXPECT_TRUE(found.at(64, 51));
  EXPECT_FALSE(found.at(2, 2));
}

TEST_F(InterestedRays, DoNotFillALetterC) {
  const Pixels found = of(arc({6.4, 5.1, 0}, 4, 30, 330), grid(130, 110, 0.1F, 0.1F), 0.2F);
  EXPECT_FALSE(found.at(64, 51));
  EXPECT_TRUE(found.at(24, 51));
}

TEST_F(InterestedRays, FillARingWithinTheGapOfALetterC) {
  Surface surface = arc({6.4, 5.1, 0}, 4.5, 30, 330);
  append(surface, arc({6.4, 5.1, 0}, 2, 0, 360));
  const Pixels found = of(surface, grid(130, 110, 0.1F, 0.1F), 0.2F);
  EXPECT_TRUE(found.at(64, 51));
  EXPECT_FALSE(found.at(64, 85)) << "between ring and C";
}

TEST_F(InterestedRays, DoNotFillASpiralThatLeadsOutside) {
  Surface spiral;
  for (double a = 0; a < 6 * 2 * kPi; a += 0.02) {
    spiral.push_back({Vec3d(6 + a / 8 * std::cos(a), 6 + a / 8 * std::sin(a), 0), Vec3d(0, 0, 1)});
  }
  of(spiral, grid(129, 125, 0.1F, 0.1F), 0.08F);
}

TEST_F(InterestedRays, AreDiscsAlsoOnOblongPixelsAndAcrossTheEdgesOfThePanel) {
  Random random(71);
  for (int round = 0; round < 30; ++round) {
    Surface surface;
    for (int i = 0; i < 25; ++i) {
      surface.push_back({Vec3d(random.uniform(-3, 16), random.uniform(-3, 14), 0), Vec3d(0, 0, 1)});
    }
    of(surface, grid(1 + random.below(140), 1 + random.below(60), 0.1F, 0.2F),
       static_cast<float>(random.uniform(0.05, 1)));
  }
}

TEST_F(InterestedRays, AreTheSameForAnyNumberOfThreads) {
  const int before = omp_get_max_threads();
  for (const int threads : {1, 2, 5}) {
    omp_set_num_threads(threads);
    Random random(72);
    Surface surface;
    for (int i = 0; i < 60; ++i) {
      surface.push_back({Vec3d(random.uniform(-1, 14), random.uniform(-1, 8), 0), Vec3d(0, 0, 1)});
    }
    of(surface, grid(130, 70, 0.1F, 0.1F), 0.6F);
    of(surface, grid(130, 3, 0.1F, 0.1F), 0.6F);
  }
  omp_set_num_threads(before);
}

TEST_F(InterestedRays, NeedOneMoreImage) {
  ASSERT_TRUE(arena_->take_top<std::byte>(arena_->available() - 4096, "the rest").has_value());
  const Cloud empty;
  OwnedImage interested(1000, 1000);
  const Status status = find_interested_rays(empty, grid(1000, 1000, 0.1F, 0.1F), 0.2F, interested.view(), *arena_);
  ASSERT_FALSE(status.has_value());
  EXPECT_EQ(status.error().code(), ErrorCode::kOutOfMemory);
}

}  // namespace
}  // namespace plumbline
