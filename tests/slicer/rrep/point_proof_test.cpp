#include "slicer/rrep/point_proof.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/voxel_store.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// Points at equal distances from a box of 20 x 20 x 20 voxels, whose corner is voxel (20, 20, 20) of 60 x 60 x 60: over each of its faces.
std::vector<Vec3f> over_faces(float distance, float voxel) {
  std::vector<Vec3f> points;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {20 * voxel - distance, 40 * voxel + distance}) {
      for (int i = 8; i < 12; ++i) {
        Vec3f p = Vec3f::Constant((20.5F + static_cast<float>(i)) * voxel);
        p[axis] = side;
        points.push_back(p);
      }
    }
  }
  return points;
}

TEST(PointProof, CountsPointsByTheirDistanceFromABox) {
  Voxels voxels(60, 60, 60);
  voxels.fill({20, 20, 20}, {40, 40, 40}, true);
  ArenaBlock arena(4 * kMiB);
  const CrossingStore store = store_of(voxels, *arena);
  const float voxel = voxels.grid.pitch_x_mm;
  const auto at = [&](float distance) { return prove(store, over_faces(distance * voxel, voxel), 4 * voxel); };
  for (const float near : {-.4F, 0.F, .4F}) {
    const PointProof proof = at(near);
    EXPECT_EQ(proof.within_pixel, proof.points) << near;
    EXPECT_EQ(proof.off, 0U) << near;
  }
  for (const float within : {-3.4F, 3.4F}) {
    const PointProof proof = at(within);
    EXPECT_EQ(proof.within_pixel, 0U) << within;
    EXPECT_EQ(proof.off, 0U) << within;
  }
  for (const float beyond : {-5.6F, 5.6F, 15.F}) {
    const PointProof proof = at(beyond);
    EXPECT_EQ(proof.within_layer, 0U) << beyond;
    EXPECT_EQ(proof.off, proof.points) << beyond;
  }
  // Never less than two pixels and two layers.
  EXPECT_FLOAT_EQ(prove(store, over_faces(0, voxel), 0).reach_mm, 2 * voxel);
}

TEST(PointProof, ACleanScanIsPrintedWhereItsPointsAre) {
  const Slicing sliced(binary_ply(sphere(60000, 10, {0, 0, 0})), settings_with_pitch(0.1F), 64 * kMiB);
  const PointProof& proof = sliced.report().proof;
  EXPECT_EQ(proof.points, kMostProofPoints);
  EXPECT_GT(proof.within_pixel, 0.99 * proof.points);
  EXPECT_LT(proof.off, 0.005 * proof.points);
}

/// A ball that was scanned twice, `apart` mm from each other: surface of one lies inside the other.
Surface two_balls(std::uint32_t others, double apart) {
  Surface surface = sphere(20000, 10, {0, 0, 0});
  const Surface other = sphere(others, 10, {apart, 0, 0});
  surface.insert(surface.end(), other.begin(), other.end());
  return surface;
}

TEST(PointProof, SurfaceThatIsNotPrintedIsOff) {
  const Slicing sliced(binary_ply(two_balls(20000, 9)), settings_with_pitch(0.1F), 64 * kMiB);
  // Of either ball the cap that lies in the other one, (1 - 4.5 / 10) / 2 of it, but for its rim.
  EXPECT_NEAR(sliced.report().proof.share_off(), 0.23, 0.05);
}

}  // namespace
}  // namespace plumbline
