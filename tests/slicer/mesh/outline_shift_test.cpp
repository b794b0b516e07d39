/// absolute_correction: the outlines of a mesh's layers are moved.

#include "slicer/mesh/outline_shift.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/slicer/mesh/sliced_mesh.hpp"

namespace plumbline {
namespace outline_shift_test {

using namespace testing;
using ::testing::HasSubstr;

SliceSettings moved_by(double mm, float pitch) {
  SliceSettings settings = settings_with_pitch(pitch);
  settings.absolute_correction_mm = mm;
  settings.placement.room.beside_mm = std::max(0.0, mm);
  return settings;
}

bool same_rrep(const RRep& a, const RRep& b) {
  return std::ranges::equal(a.first, b.first) && std::ranges::equal(a.packed, b.packed);
}

TEST(OutlineShift, MovesEachWallOfABoxAndNeitherItsTopNorItsUnderside) {
  for (const double by : {-0.3, 0.3}) {
    const Slicing box = sliced(box_mesh({0, 0, 0}, {7, 5, 3}), moved_by(by, 0.1F));
    const Vec3d more(by, by, 0);
    EXPECT_EQ(wrong(box, [&](const Vec3d& p) { return in_box(p, -more, Vec3d(7, 5, 3) + more); }), 0U) << by;
    EXPECT_EQ(box.grid().layers, 30U);
    EXPECT_TRUE(box.report().mesh->closed);
  }
}

// One bit a pixel: only the mean of a wall that does not lie along them can follow.
TEST(OutlineShift, MovesTheMeanOfAWallByPartsOfAPixel) {
  SliceSettings settings = moved_by(0, 0.1F);
  settings.placement.rotation_degrees = {0, 0, 17.3};
  for (const double by : {-0.02, -0.01, 0.01, 0.02}) {
    settings.absolute_correction_mm = by;
    const Slicing bar = sliced(box_mesh({0, 0, 0}, {31, 23, 2}), settings);
    const double moved = (bar.volume() / 2 - 31 * 23) / (2 * (31 + 23));
    EXPECT_NEAR(moved, by, 0.0015);
  }
}

TEST(OutlineShift, MovesTheOutlineOfEachLayerOfABall) {
  for (const double by : {-0.25, 0.25}) {
    const Slicing ball = sliced(ball_mesh({0, 0, 8}, 8, 5), moved_by(by, 0.1F));
    // Near the poles the outlines are no longer than the move.
    const auto inside = [&](const Vec3d& p) {
      const double z = p[2] - 8;
      if (std::abs(z) > 6.5) return 0;
      const double out = std::sqrt(p[0] * p[0] + p[1] * p[1]) - (std::sqrt(64 - z * z) + by);
      return std::abs(out) < 0.03 ? 0 : out < 0 ? 1 : -1;
    };
    EXPECT_EQ(wrong(ball, inside), 0U) << by;
    EXPECT_EQ(ball.report().mesh->broken_rays, 0U);
  }
}

TEST(OutlineShift, WidensAHoleWhereItNarrowsAPin) {
  TestMesh tube = box_mesh({0, 0, 0}, {10, 10, 4});
  TestMesh hole = box_mesh({3, 3, 1}, {7, 7, 3});
  flip(hole, 0, hole.faces.size());
  append(tube, hole);
  const Slicing sliced_tube = sliced(tube, moved_by(-0.2, 0.1F));
  const auto inside = [](const Vec3d& p) {
    const int outer = in_box(p, {0.2, 0.2, 0}, {9.8, 9.8, 4}), inner = in_box(p, {2.8, 2.8, 1}, {7.2, 7.2, 3});
    return outer == 0 || inner == 0 ? 0 : outer > 0 && inner < 0 ? 1 : -1;
  };
  EXPECT_EQ(wrong(sliced_tube, inside), 0U);
}

TEST(OutlineShift, MovesAMeshThatIsInsideOutTheSameWay) {
  TestMesh boxes = box_mesh({0, 0, 0}, {7, 5, 3});
  append(boxes, box_mesh({9, 0, 0}, {12, 5, 2}));
  const Slicing right = sliced(boxes, moved_by(-0.25, 0.1F));
  flip(boxes, 0, 12);
  const Slicing one = sliced(boxes, moved_by(-0.25, 0.1F));
  EXPECT_EQ(one.report().mesh->turned, 12U);
  EXPECT_TRUE(same_rrep(right.rrep(), one.rrep()));
  flip(boxes, 12, 24);
  const Slicing both = sliced(boxes, moved_by(-0.25, 0.1F));
  EXPECT_TRUE(same_rrep(right.rrep(), both.rrep()));
}

TEST(OutlineShift, LeavesAWallBetweenBoxesThatTouchWhereItIs) {
  TestMesh two = box_mesh({0, 0, 0}, {5, 10, 3});
  append(two, box_mesh({5, 0, 0}, {10, 10, 3}));
  const Slicing both = sliced(two, moved_by(-0.2, 0.1F));
  EXPECT_EQ(wrong(both, [](const Vec3d& p) { return in_box(p, {0.2, 0.2, 0}, {9.8, 9.8, 3}); }), 0U);
}

TEST(OutlineShift, MovesASharpEdgeByItsMitreAtMost) {
  ArenaBlock arena(kMiB);
  OutlineShift shift = value_of(OutlineShift::create(2, *arena));
  // A blade along z of 2 degrees, whose edge would move by 57 times as much.
  const double across = std::tan(kPi / 180);
  const LatticeTriangle left = {LatticePoint{0, 0, 0}, LatticePoint{0, 0, 9}, LatticePoint{9, 1, 0}};
  const LatticeTriangle right = {LatticePoint{0, 0, 9}, LatticePoint{0, 0, 0}, LatticePoint{9, 0, 0}};
  ASSERT_TRUE(shift.add(left, {Vec3d(0, 0, 0), Vec3d(0, 0, 1), Vec3d(1, across, 0)}));
  ASSERT_TRUE(shift.add(right, {Vec3d(0, 0, 1), Vec3d(0, 0, 0), Vec3d(1, -across, 0)}));
  shift.solve(0.1, {1e-3, 1e-3, 1e-3});
  const auto move = shift.move_of({0, 0, 0});
  EXPECT_NEAR(static_cast<double>(move[0]), -100 * OutlineShift::kMitre, 1);
  EXPECT_NEAR(static_cast<double>(move[1]), 0, 1);
  EXPECT_EQ(shift.move_of({5, 5, 5}), (std::array<std::int64_t, 3>{}));
}

TEST(OutlineShift, RefusesTrianglesThatShareNoCorners) {
  TestMesh soup;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const double x = 0.1 * (i % 60), y = 0.1 * (i / 60), z = 0.002 * i;
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const Vec3d& p : {Vec3d(x, y, z), Vec3d(x + 0.05, y, z), Vec3d(x, y + 0.05, z + 0.05)}) {
      soup.vertices.push_back(p);
    }
    soup.faces.push_back({first, first + 1, first + 2});
  }
  ArenaBlock arena(kArena);
  const std::string bytes = binary_stl(soup);
  MemorySource source(bytes, "soup.stl");
  SliceReport report;
  const auto refused = slice(source, moved_by(-0.02, 0.1F), *arena, nullptr, report);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), ErrorCode::kBadSetting);
  EXPECT_THAT(refused.error().message(), HasSubstr("hardly any share one"));
}

}  // namespace outline_shift_test
}  // namespace plumbline
