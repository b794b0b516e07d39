#include "slicer/views/registration.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <cmath>
#include <vector>

#include "slicer/views/moved_views.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/stop.hpp"
#include "tests/slicer/views/scanned_views.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A scan in the form that register_views() takes.
struct Scan {
  ArenaBlock block{48 * kMiB};
  Cloud cloud;
  std::vector<std::uint32_t> from;  ///< index in the scan of each point of the cloud
  KdTree3 tree;

  /// @param views  of each point
  Scan(const Surface& surface, const std::vector<std::uint8_t>& views)
      : cloud(cloud_of(surface, *block, 0, views)), tree(value_of(KdTree3::build(cloud.positions(), *block, "test"))) {
    from.assign(tree.order().begin(), tree.order().end());
    cloud.reorder(tree.order());
  }
  Registration align() { return value_of(register_views(cloud, tree, *block)); }
  std::vector<Vec3f> positions() const { return {cloud.positions().begin(), cloud.positions().end()}; }
};

/// RMS error of the points along the normal, compared with views that are all in place, mm.
double error(const Scan& scan, const ScannedViews& truth) {
  double sum = 0;
  for (std::uint32_t i = 0; i < scan.cloud.size; ++i) {
    const Vec3d by = scan.cloud.position[i].cast<double>() - truth.unmoved[scan.from[i]];
    const double along = by.dot(truth.surface[scan.from[i]].normal);
    sum += along * along;
  }
  return std::sqrt(sum / scan.cloud.size);
}

TEST(RegisterViews, MovesViewsBackToWhereTheyAgree) {
  const ScannedViews truth = scan_ellipsoid({}, 1);
  Scan scan(truth.surface, truth.view);
  const double before = error(scan, truth);
  const std::size_t used = scan.block->used();
  scan.block->reset_peak();
  const Registration done = scan.align();
  EXPECT_EQ(scan.block->used(), used);
  EXPECT_LE(scan.block->peak() - used, register_views_bytes(scan.cloud.views.count) + 8 * Arena::kAlignment);
  EXPECT_GT(before, 0.04);
  EXPECT_LT(error(scan, truth), before / 4);
  EXPECT_GT(done.moved, 0.04F);
  EXPECT_NEAR(done.after, 0.034, 0.004) << "noise of 0.05 mm along rays that meet the surface at all angles";
  EXPECT_GT(done.before, done.after + 0.005F);
}

TEST(RegisterViews, MovesViewsFarApartAndManyOfThem) {
  for (const std::uint32_t views : {4U, 60U}) {
    // As many points in all, whatever their number.
    const ScannedViews truth =
        scan_ellipsoid({.views = views, .pixel = 0.1 * std::sqrt(views), .noise = 0.02, .shift = 0.15}, 1);
    Scan scan(truth.surface, truth.view);
    const double before = error(scan, truth);
    const Registration done = scan.align();
    EXPECT_GT(done.moved, 0.1F) << views << " views, off by " << done.before << ", then " << done.after;
    EXPECT_LT(error(scan, truth), before / 2) << views;
  }
}

TEST(RegisterViews, TakesSomeRoomForHundredsOfViews) {
  const ScannedViews truth = scan_ellipsoid({.views = 200, .pixel = 1.4}, 1);
  Scan scan(truth.surface, truth.view);
  const double before = error(scan, truth);
  const std::size_t used = scan.block->used();
  scan.block->reset_peak();
  EXPECT_EQ(scan.align().views, MovedViews::kMost);
  EXPECT_LE(scan.block->peak() - used, 5 * kMiB);
  EXPECT_LE(error(scan, truth), before) << "those beside each other move together";
}

TEST(RegisterViews, LeavesViewsThatAgreeInPlace) {
  const ScannedViews truth = scan_ellipsoid({.noise = 0.08, .shift = 0, .turn = 0}, 2);
  Scan scan(truth.surface, truth.view);
  const std::vector<Vec3f> as_read = scan.positions();
  EXPECT_EQ(scan.align().moved, 0.0F);
  EXPECT_EQ(scan.positions(), as_read);
}

TEST(RegisterViews, LeavesPointsOfNoViewAndASingleViewInPlace) {
  ScannedViews truth = scan_ellipsoid({}, 4);
  std::vector<std::uint8_t> one(truth.view.size(), 0);
  Scan single(truth.surface, one);
  EXPECT_EQ(single.align().moved, 0.0F);
  for (std::size_t i = 0; i < truth.view.size(); i += 3) truth.view[i] = kNoView;
  Scan scan(truth.surface, truth.view);
  const std::vector<Vec3f> as_read = scan.positions();
  EXPECT_GT(scan.align().moved, 0.0F);
  for (std::uint32_t i = 0; i < scan.cloud.size; ++i) {
    EXPECT_EQ(scan.cloud.position[i] == as_read[i], scan.cloud.views.of[i] == kNoView);
  }
}

TEST(RegisterViews, StopsWhenCancelled) {
  const ScannedViews truth = scan_ellipsoid({}, 1);
  Scan scan(truth.surface, truth.view);
  StopAtThird sink;
  const auto stopped = register_views(scan.cloud, scan.tree, *scan.block, {&sink, Stage::kViews});
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().code(), ErrorCode::kCancelled);
}

/// A plate of 30 mm x 30 mm x 2 mm, seen by three views from above and three from below, each shifted up or down.
TEST(RegisterViews, KeepsThePlatesThicknessForAnyNumberOfThreads) {
  constexpr std::array<double, 6> kShifts = {0.06, -0.02, -0.04,
                                             0.07, -0.03, -0.04};  // mm; their mean over each side is 0
  Random random(1);
  Surface surface;
  std::vector<std::uint8_t> view;
  for (int k = 0; k < 60000; ++k) {
    const std::uint32_t of = random.below(6);
    const double side = of < 3 ? 1 : -1;
    surface.push_back({{random.uniform(-15, 15), random.uniform(-15, 15), side + kShifts[of] + 0.03 * random.normal()},
                       {0, 0, side}});
    view.push_back(static_cast<std::uint8_t>(of));
  }
  std::vector<std::vector<Vec3f>> results;
  for (const int threads : {3, 1}) {
    omp_set_num_threads(threads);
    Scan scan(surface, view);
    EXPECT_LT(scan.align().after, 0.034F) << "noise of 0.03 mm";
    results.push_back(scan.positions());
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
