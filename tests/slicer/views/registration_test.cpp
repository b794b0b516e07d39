#include "slicer/views/registration.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A plate of 30 mm x 30 mm x 2 mm, seen by three views from above and three from below, each shifted up or down.
TEST(RegisterViews, KeepsThePlatesThicknessWhenSomePointsAreAssignedToAViewOfTheOtherSide) {
  constexpr std::array<double, 6> kShifts = {0.06, -0.02, -0.04,
                                             0.07, -0.03, -0.04};  // mm; their mean over each side is 0
  constexpr double kWrongShare = 0.02;  // share of the points that lie on another view's grid by chance
  Random random(1);
  Surface surface;
  std::vector<std::uint8_t> view;
  for (int k = 0; k < 60000; ++k) {
    const std::uint32_t of = random.below(6);
    const double side = of < 3 ? 1 : -1;
    surface.push_back({{random.uniform(-15, 15), random.uniform(-15, 15), side + kShifts[of] + 0.03 * random.normal()},
                       {0, 0, side}});
    // Some points of the first view of a side are assigned to the first view of the other side.
    view.push_back(static_cast<std::uint8_t>(of % 3 == 0 && random.uniform() < 6 * kWrongShare ? 3 - of : of));
  }
  std::array<ViewGrid, 6> grids;
  for (ViewGrid& grid : grids) {  // all look along z
    grid.map[0] = 2;
    grid.map[5] = 2;
  }
  std::vector<std::vector<Vec3f>> results;
  for (const int threads : {3, 1}) {
    omp_set_num_threads(threads);
    ArenaBlock block(64 * kMiB);
    Cloud cloud = cloud_of(surface, *block);
    KdTree3 tree = value_of(KdTree3::build(cloud.positions(), *block, "test"));
    std::vector<std::uint8_t> of;
    for (const std::uint32_t i : tree.order()) of.push_back(view[i]);
    cloud.reorder(tree.order());
    const Registration done = value_of(register_views(cloud, tree, {of, grids, 0.2F}, *block));
    EXPECT_LT(done.after, 0.034F) << "noise of 0.03 mm";
    EXPECT_EQ(done.ripple, 0.0F);
    results.emplace_back(cloud.positions().begin(), cloud.positions().end());
  }
  EXPECT_EQ(results[0], results[1]);
  double upper = 0;
  double lower = 0;
  int uppers = 0;
  int lowers = 0;
  for (const Vec3f& p : results[1]) {
    (p[2] > 0 ? upper : lower) += static_cast<double>(p[2]);
    ++(p[2] > 0 ? uppers : lowers);
  }
  EXPECT_NEAR(upper / uppers - lower / lowers, 2, 0.004);
}

}  // namespace
}  // namespace plumbline
