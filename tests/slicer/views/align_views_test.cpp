#include "slicer/views/align_views.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "slicer/core/numbers/lanes.hpp"
#include "slicer/views/find_views.hpp"
#include "slicer/views/view_grid.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/stop.hpp"
#include "tests/slicer/views/scanned_views.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr float kSpacing = 0.2F;  ///< mm, of the scans' points

/// A scan in the form that align_views() takes.
struct Scan {
  ArenaBlock block{48 * kMiB};
  Cloud cloud;
  KdTree3 tree;
  std::vector<std::uint32_t> from;  ///< index in the scan of each point of the cloud

  explicit Scan(const Surface& surface)
      : cloud(cloud_of(surface, *block)), tree(value_of(KdTree3::build(cloud.positions(), *block, "test"))) {
    from.assign(tree.order().begin(), tree.order().end());
    cloud.reorder(tree.order());
  }
  ViewAlignment align() { return value_of(align_views(cloud, tree, *block)); }
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

/// Fits a grid to the one view of a scan, from a start a third of a pixel off and without perspective or lens.
ViewGrid fit_from_a_third_of_a_pixel_off(const ScannedViews& scan) {
  ViewGrid grid;
  grid.middle = scan.surface[scan.surface.size() / 2].position.cast<float>();
  const Vec3d ahead = -sphere(1, 1, Vec3d::Zero())[0].normal;
  const Vec3d right = ahead.cross(Vec3d(0.3, 0.2, 0.9)).normalized();
  const double depth = 150 + ahead.dot(grid.middle.cast<double>());
  grid.map.setZero();
  grid.map.segment<3>(0) = right * 150 / depth / 0.4;
  grid.map.segment<3>(4) = ahead.cross(right) * 150 / depth / 0.4;
  grid.map[3] = 0.3;
  grid.map[7] = -0.2;
  std::vector<float> room(3 * ViewGridFit::kMaxPoints);
  const ViewGridFit fit(30, room);
  for (double radius = 3; radius < 40; radius *= 1.4) {
    std::array<std::vector<float>, 3> at;
    for (const SurfacePoint& p : scan.surface) {
      const Vec3f from = p.position.cast<float>() - grid.middle;
      if (from.norm() >= static_cast<float>(radius) || at[0].size() == ViewGridFit::kMaxPoints) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) at[axis].push_back(from[static_cast<Eigen::Index>(axis)]);
    }
    for (auto& axis : at) axis.resize(axis.size() / kLanes * kLanes);
    for (const double width : {0.45, 0.3, 0.3, 0.2, 0.1, 0.1}) {
      EXPECT_TRUE(fit.improve(grid, {at[0], at[1], at[2]}, radius, width));
    }
  }
  return grid;
}

/// Largest distance of the scan's points from the grid, pixels.
double farthest(const ViewGrid& grid, const ScannedViews& scan) {
  std::vector<Vec3f> points;
  for (const SurfacePoint& p : scan.surface) points.emplace_back(p.position.cast<float>());
  std::vector<float> distances2(points.size() + kLanes);
  distances2_within(grid, 1000, points, distances2);
  return std::sqrt(static_cast<double>(*std::max_element(distances2.begin(), distances2.end())));
}

TEST(ViewGridFit, FindsTheCameraFromAStartAThirdOfAPixelOff) {
  const ScannedViews scan = scan_ellipsoid({.views = 1, .shift = 0, .turn = 0}, 1);
  const ViewGrid grid = fit_from_a_third_of_a_pixel_off(scan);
  EXPECT_LT(farthest(grid, scan), 0.004);
}

TEST(ViewGridFit, FindsALensThatBendsOutwardsOrInwards) {
  for (const double lens : {0.1, -0.05}) {
    SCOPED_TRACE(lens);
    const ScannedViews scan = scan_ellipsoid({.views = 1, .shift = 0, .turn = 0, .lens = lens}, 1);
    const ViewGrid grid = fit_from_a_third_of_a_pixel_off(scan);
    EXPECT_LT(farthest(grid, scan), 0.01);
    // Noise moves points along their rays, whatever the lens.
    const Vec3f point = scan.surface.front().position.cast<float>();
    const Vec3f along = point + (grid.ray(point) * 2).cast<float>();
    EXPECT_NEAR(grid.project(along).u, grid.project(point).u, 1e-3);
    EXPECT_NEAR(grid.project(along).v, grid.project(point).v, 1e-3);
  }
}

TEST(FindViews, FindsTheSameViewsOfAShuffledScanForAnyNumberOfThreads) {
  const ScannedViews truth = scan_ellipsoid({}, 1);
  Scan scan(truth.surface);
  std::vector<std::uint8_t> found(scan.cloud.size);
  FoundViews views;
  for (const int threads : {3, 1}) {
    const std::vector<std::uint8_t> before = found;
    omp_set_num_threads(threads);
    views = value_of(find_views(scan.cloud, scan.tree, kSpacing, found, *scan.block));
    if (threads == 1) {
      EXPECT_EQ(found, before);
    }
  }
  EXPECT_GE(views.count, 11U);
  EXPECT_LE(views.count, 16U);
  EXPECT_GT(views.points, 0.9 * scan.cloud.size);
  std::map<std::pair<std::uint8_t, std::uint8_t>, std::uint32_t> together;
  for (std::uint32_t i = 0; i < scan.cloud.size; ++i) {
    if (found[i] != kNoView) ++together[{found[i], truth.view[scan.from[i]]}];
  }
  std::uint32_t right = 0;
  for (std::uint32_t v = 0; v < views.count; ++v) {
    std::uint32_t most = 0;
    for (const auto& [pair, points] : together) {
      if (pair.first == v) most = std::max(most, points);
    }
    right += most;
  }
  EXPECT_GT(right, 0.98 * views.points);
}

/// @returns how many views the search finds in a scan
std::uint32_t views_in(const Surface& surface, float spacing = kSpacing) {
  Scan scan(surface);
  std::vector<std::uint8_t> found(scan.cloud.size);
  const FoundViews views = value_of(find_views(scan.cloud, scan.tree, spacing, found, *scan.block));
  EXPECT_EQ(std::any_of(found.begin(), found.end(), [](std::uint8_t v) { return v != kNoView; }), views.count > 0);
  return views.count;
}

TEST(FindViews, FindsNoneInFlatFacesThatAreSampledByVoxels) {
  constexpr double kVoxel = 0.25;  // mm
  Random random(6);
  Surface plate;
  for (const double side : {-1.0, 1.0}) {
    for (int i = -90; i < 90; ++i) {
      for (int j = -90; j < 90; ++j) {
        for (const double height : {4.0, 4.0 + kVoxel}) {
          const Vec3d off = random.vector() * 0.06 * kVoxel;
          plate.push_back({Vec3d(i * kVoxel, j * kVoxel, height * side) + off, Vec3d(0, 0, side)});
        }
      }
    }
  }
  EXPECT_EQ(views_in(plate, 0.18F), 0U);
}

TEST(FindViews, FindsNoneWhereTheGridsBendAsNoCameraBendsThem) {
  EXPECT_EQ(views_in(scan_ellipsoid({.wobble = 1}, 1).surface), 0U);
}

TEST(ViewGrid, ProjectsTheSameAroundAnotherMiddle) {
  ViewGrid grid;
  grid.middle = Vec3f(1, 2, 3);
  grid.map << 2, 0.1, 0.3, 0.4, -0.2, 2.1, 0.5, -0.3, 0.004, 0.002, -0.005;
  const ViewGrid moved = grid.around(Vec3f(-2, 5, 4));
  const Vec3f point(7, -1, 2);
  EXPECT_NEAR(moved.project(point).u, grid.project(point).u, 1e-9);
  EXPECT_NEAR(moved.project(point).v, grid.project(point).v, 1e-9);
  const Vec3d ray = grid.ray(point);
  EXPECT_NEAR(ray.norm(), 1, 1e-12);
  const Vec3f along = point + (ray * 4).cast<float>();
  EXPECT_NEAR(grid.project(along).u, grid.project(point).u, 1e-5);
  EXPECT_NEAR(grid.project(along).v, grid.project(point).v, 1e-5);
}

TEST(AlignViews, MovesViewsBackToWhereTheyAgree) {
  const ScannedViews truth = scan_ellipsoid({}, 1);
  Scan scan(truth.surface);
  const double before = error(scan, truth);
  const std::size_t used = scan.block->used();
  const auto threads = static_cast<std::uint32_t>(omp_get_max_threads());
  scan.block->reset_peak();
  const ViewAlignment done = scan.align();
  EXPECT_EQ(scan.block->used(), used);
  EXPECT_LE(scan.block->peak() - used, align_views_bytes(done, scan.cloud.size, threads) + 32 * Arena::kAlignment);
  EXPECT_LE(align_views_bytes(done, scan.cloud.size, threads), align_views_bytes(scan.cloud.size, threads));
  EXPECT_GT(before, 0.04);
  EXPECT_LT(error(scan, truth), before / 4);
  EXPECT_GT(done.moved, 0.04F);
  EXPECT_NEAR(done.after, 0.034, 0.004) << "noise of 0.05 mm along rays that meet the surface at all angles";
  EXPECT_GT(done.before, done.after + 0.005F);
}

TEST(AlignViews, MovesViewsThatWereSeenThroughALens) {
  const ScannedViews truth = scan_ellipsoid({.lens = 0.05}, 1);
  Scan scan(truth.surface);
  const double before = error(scan, truth);
  const ViewAlignment done = scan.align();
  EXPECT_GE(done.views, 11U);
  EXPECT_LE(done.views, 14U);
  EXPECT_GT(done.points, 0.97 * scan.cloud.size);
  EXPECT_LT(error(scan, truth), before / 4);
}

TEST(AlignViews, RemovesTheRippleThatFringesLeave) {
  const ScannedViews truth = scan_ellipsoid({.noise = 0.08, .shift = 0.02, .turn = 0.001, .ripple = 0.03}, 5);
  Scan scan(truth.surface);
  const double before = error(scan, truth);
  const ViewAlignment done = scan.align();
  EXPECT_GT(before, 0.025);
  EXPECT_LT(error(scan, truth), before / 2.5);
  EXPECT_NEAR(done.ripple, 0.03, 0.008) << "two waves of 0.03 mm";
}

TEST(AlignViews, LeavesViewsThatAgreeInPlace) {
  const ScannedViews truth = scan_ellipsoid({.noise = 0.08, .shift = 0, .turn = 0}, 2);
  Scan scan(truth.surface);
  const std::vector<Vec3f> as_read = scan.positions();
  const ViewAlignment done = scan.align();
  EXPECT_GE(done.views, 11U);
  EXPECT_EQ(done.moved, 0.0F);
  EXPECT_EQ(scan.positions(), as_read);
}

TEST(AlignViews, SearchesNoViewsInAScanWithoutNoise) {
  Scan scan(scan_ellipsoid({.noise = 0.01, .shift = 0, .turn = 0}, 3).surface);
  EXPECT_EQ(scan.align().views, 0U);
}

TEST(AlignViews, LeavesPointsThatBelongToNoViewInPlace) {
  Random random(4);
  Surface anywhere;
  for (int k = 0; k < 60000; ++k) {
    const Vec3d n = random.vector().normalized();
    anywhere.push_back({n * 15 + 0.05 * random.vector(), n});
  }
  Scan scan(anywhere);
  const std::vector<Vec3f> as_read = scan.positions();
  EXPECT_EQ(scan.align().moved, 0.0F);
  EXPECT_EQ(scan.positions(), as_read);
}

TEST(AlignViews, StopsWhenCancelled) {
  Scan scan(scan_ellipsoid({}, 1).surface);
  StopAtThird sink;
  const auto stopped = align_views(scan.cloud, scan.tree, *scan.block, {&sink, Stage::kViews});
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().code(), ErrorCode::kCancelled);
}

}  // namespace
}  // namespace plumbline
