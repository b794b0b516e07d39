#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "slicer/normals/normals.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/virtual_scanner.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kGrazing = 0.17364818;  ///< sine of 10 degrees

/// Points whose normal faces the other side than the surface there.
struct WrongSides {
  std::uint32_t wrong = 0;    ///< seen at more than 10 degrees
  std::uint32_t grazing = 0;  ///< the others
  std::uint32_t across = 0;   ///< the direction is off by more than 45 degrees, at edges
};

enum class GivenNormals : std::uint8_t { kNone, kSigned, kHalfTurned };

WrongSides wrong_sides(const SeenSurface& seen, GivenNormals given) {
  ArenaBlock arena(300 * seen.points.size() + kMiB);
  Cloud cloud = cloud_of(seen, *arena);
  const std::vector<PackedNormal> normals(cloud.normal.begin(), cloud.normal.begin() + cloud.size);
  Random random(3);
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (given == GivenNormals::kNone) cloud.normal[i] = {};
    if (given == GivenNormals::kHalfTurned && random.below(2) == 1) cloud.normal[i].turn_over();
    cloud.radius[i] = static_cast<float>(i);  // goes along to the tree's order
  }
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  std::vector<std::uint32_t> was(cloud.size);
  for (std::uint32_t i = 0; i < cloud.size; ++i) was[i] = static_cast<std::uint32_t>(cloud.radius[i]);
  value_of(complete_normals(cloud, tree, *arena));
  WrongSides sides;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    EXPECT_TRUE(cloud.radius[i] > 0 && cloud.radius[i] < 5);
    const Vec3d exact = seen.points[was[i]].normal;
    const double cosine = exact.dot(cloud.normal[i].unpack().cast<double>());
    const Vec3d ray = (seen.points[was[i]].position - seen.scanners[seen.view_of[was[i]]]).normalized();
    if (std::abs(cosine) < .70710678) {
      ++sides.across;
    } else if (cosine < 0) {
      ++(std::abs(exact.dot(ray)) > kGrazing ? sides.wrong : sides.grazing);
    }
  }
  return sides;
}

TEST(SeenSides, AreThoseOfTheScanners) {
  for (const ThinSolid& solid : kThinSolids) {
    for (const double noise : {0.0, .03}) {
      const SeenSurface seen = scan_all_around(solid.distance, .5, noise);
      for (const auto given : {GivenNormals::kNone, GivenNormals::kSigned, GivenNormals::kHalfTurned}) {
        SCOPED_TRACE(solid.name);
        const WrongSides sides = wrong_sides(seen, given);
        EXPECT_EQ(sides.wrong, 0U) << "of " << seen.points.size();
        EXPECT_LT(sides.grazing, 10U);
        EXPECT_LT(sides.across, given == GivenNormals::kNone ? .1 * static_cast<double>(seen.points.size()) : 1);
      }
    }
  }
}

// A scanner that stood nowhere known has seen the upper half.
TEST(SeenSides, DecideForThePointsAround) {
  SeenSurface seen = scan_all_around(kThinSolids[3].distance, .5);
  ArenaBlock arena(300 * seen.points.size() + kMiB);
  for (const bool given : {false, true}) {
    const ArenaScope scope(*arena);
    Cloud cloud = cloud_of(seen, *arena);
    for (std::uint32_t i = 0; i < cloud.size; ++i) {
      given ? cloud.normal[i].turn_over() : void(cloud.normal[i] = {});
      if (cloud.position[i][2] > 0) cloud.views.of[i] = kNoView;
    }
    const KdTree3 tree = sort_by_tree(cloud, *arena);
    const NormalCounts counts = value_of(complete_normals(cloud, tree, *arena));
    EXPECT_EQ(counts.estimated, given ? 0U : cloud.size);
    EXPECT_EQ(counts.turned, given ? cloud.size : 0U);
    std::uint32_t wrong = 0;
    for (std::uint32_t i = 0; i < cloud.size; ++i) {
      const Vec3f& p = cloud.position[i];
      const Vec3f inner = 9 * Vec3f(p[0], p[1], 0).normalized();
      wrong += (p - inner).dot(cloud.normal[i].unpack()) > 0 ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0U);
  }
}

// Programs that merge clouds keep the place of the first scanner.
TEST(SeenSides, AreNotThoseOfAScannerThatCanNotHaveSeenThem) {
  for (const std::size_t solid : {2U, 3U}) {
    SeenSurface seen = scan_all_around(kThinSolids[solid].distance, .25, .02);
    EXPECT_EQ(wrong_sides(seen, GivenNormals::kSigned).wrong, 0U);
    std::ranges::fill(seen.view_of, 0);
    ArenaBlock arena(300 * seen.points.size() + kMiB);
    Cloud cloud = cloud_of(seen, *arena);
    const KdTree3 tree = sort_by_tree(cloud, *arena);
    const NormalCounts counts = value_of(complete_normals(cloud, tree, *arena));
    EXPECT_EQ(cloud.views.scanners(), 11U) << "of which none has points";
    EXPECT_LT(counts.turned, 10U);
  }
}

TEST(SeenSides, AreTheSameForAnyNumberOfThreads) {
  const SeenSurface seen = scan_all_around(kThinSolids[4].distance, 1, .05);
  ArenaBlock arena(600 * seen.points.size() + kMiB);
  std::vector<Vec3f> normals[2];
  for (const int threads : {1, 3}) {
    omp_set_num_threads(threads);
    const ArenaScope scope(*arena);
    Cloud cloud = cloud_of(seen, *arena);
    for (std::uint32_t i = 0; i < cloud.size; ++i) cloud.normal[i] = {};
    const KdTree3 tree = sort_by_tree(cloud, *arena);
    value_of(complete_normals(cloud, tree, *arena));
    for (std::uint32_t i = 0; i < cloud.size; ++i) normals[threads / 2].push_back(cloud.normal[i].unpack());
  }
  EXPECT_EQ(normals[0], normals[1]);
}

}  // namespace
}  // namespace plumbline
