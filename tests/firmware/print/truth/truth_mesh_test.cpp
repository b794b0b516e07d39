#include "firmware/print/truth/truth_mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/firmware/support/job_fixture.hpp"
#include "tests/slicer/support/meshes.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// What a file is refused for, or nothing.
std::string refusal_of(const std::string& path) {
  const auto mesh = TruthMesh::read(path);
  return mesh ? "" : std::string(mesh.error().message());
}

TEST(TruthMesh, IsSpreadEvenlyOverTheSurfaceWhereItIsPrinted) {
  const TemporaryFolder folder;
  testing::TestMesh box = testing::box_mesh({1, 2, 3}, {5, 12, 8});
  for (const bool inside_out : {false, true}) {
    if (inside_out) testing::flip(box, 0, box.faces.size());
    write_text(folder / "box.stl", testing::binary_stl(box));
    const auto mesh = TruthMesh::read(folder / "box.stl");
    ASSERT_TRUE(mesh) << mesh.error().message();
    Placement placement;
    placement.rotation = rotation_matrix({0, 90, 0});  // x becomes -z, z becomes x
    placement.scale = 2;
    placement.shift = {10, 20, 30};
    const TrueSurface surface = mesh->surface(placement);
    EXPECT_EQ(surface.name, "box.stl");
    ASSERT_NEAR(static_cast<double>(surface.points.size()), 50'000, 1);
    std::array<double, 6> on = {}, first_half = {};
    for (const OrientedPoint& p : surface.points) {
      const Vec3f low(16, 24, 20), high(26, 44, 28);
      int axis = 0;
      p.normal.cwiseAbs().maxCoeff(&axis);
      EXPECT_NEAR(std::abs(p.normal[axis]), 1, 1e-6);
      EXPECT_NEAR(p.at[axis], p.normal[axis] > 0 ? high[axis] : low[axis], 1e-5);
      const int across = (axis + 1) % 3;
      EXPECT_GE(p.at[across], low[across]);
      EXPECT_LE(p.at[across], high[across]);
      const auto side = static_cast<std::size_t>(2 * axis + (p.normal[axis] > 0 ? 1 : 0));
      ++on[side];
      first_half[side] += p.at[across] < (low[across] + high[across]) / 2 ? 1 : 0;
    }
    const double areas[] = {20 * 8, 10 * 8, 10 * 20};
    for (std::size_t side = 0; side < 6; ++side) {
      EXPECT_NEAR(on[side] / 50'000, areas[side / 2] / 880, 1e-3) << side;
      EXPECT_NEAR(first_half[side] / on[side], 0.5, 0.01) << side;
    }
  }
}

TEST(TruthMesh, MustBeAClosedMesh) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal_of(folder / "none.stl"), HasSubstr("none.stl: cannot be opened: No such file or directory"));
  write_text(folder / "empty.stl", "");
  EXPECT_THAT(refusal_of(folder / "empty.stl"), StartsWith("--truth: empty.stl: the file is empty (0 bytes)"));
  write_text(folder / "points.xyz", "0 0 0\n1 1 1\n2 1 1\n");
  EXPECT_THAT(refusal_of(folder / "points.xyz"), StartsWith("--truth: "));
  EXPECT_THAT(refusal_of(folder / "points.xyz"), HasSubstr("Name a file with a closed mesh"));
  testing::TestMesh ball = testing::ball_mesh({0, 0, 0}, 5, 2);
  write_text(folder / "ball.stl", testing::binary_stl(ball));
  EXPECT_EQ(refusal_of(folder / "ball.stl"), "");
  std::swap(ball.faces[3][0], ball.faces[3][1]);
  write_text(folder / "turned.stl", testing::binary_stl(ball));
  EXPECT_THAT(refusal_of(folder / "turned.stl"), HasSubstr("turned.stl: is not a closed surface"));
  ball.faces.erase(ball.faces.begin() + 3);
  write_text(folder / "open.stl", testing::binary_stl(ball));
  EXPECT_THAT(refusal_of(folder / "open.stl"), HasSubstr("open.stl: is not a closed surface"));
}

}  // namespace
}  // namespace plumbline::firmware
