/// The winding number by hits and open edges, against the solid angles of all triangles.

#include "slicer/mesh/open/rim_winding.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "slicer/mesh/open/small_holes.hpp"
#include "slicer/mesh/triangle_rays.hpp"
#include "tests/slicer/mesh/sliced_mesh.hpp"
#include "tests/slicer/support/arena_block.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr PrintGrid kGrid{
    .columns = 24, .rows = 24, .layers = 24, .pitch_x_mm = 0.5F, .pitch_y_mm = 0.5F, .layer_height_mm = 0.5F};

std::vector<LatticeTriangle> on_lattice(const TestMesh& mesh) {
  const MeshLattice lattice(kGrid, {});
  std::vector<LatticeTriangle> triangles;
  for (const auto& [a, b, c] : mesh.faces) {
    triangles.push_back({lattice(mesh.vertices[a]), lattice(mesh.vertices[b]), lattice(mesh.vertices[c])});
  }
  return triangles;
}

/// 1 / (4 pi) of the solid angles of all triangles (Van Oosterom and Strackee 1983).
double winding_number(const std::vector<LatticeTriangle>& triangles, const Vec3d& x) {
  const Vec3d step = MeshLattice(kGrid, {}).step();
  double sum = 0;
  for (const LatticeTriangle& t : triangles) {
    std::array<Vec3d, 3> v;
    std::array<double, 3> r{};
    for (std::size_t i = 0; i < 3; ++i) {
      v[i] = Vec3d(step[0] * t[i].x, step[1] * t[i].y, step[2] * t[i].z) - x;
      r[i] = std::sqrt(v[i].dot(v[i]));
    }
    sum += 2 * std::atan2(v[0].dot(v[1].cross(v[2])),
                          r[0] * r[1] * r[2] + v[0].dot(v[1]) * r[2] + v[1].dot(v[2]) * r[0] + v[2].dot(v[0]) * r[1]);
  }
  return sum / (4 * std::numbers::pi);
}

struct Holed {
  const char* name;
  TestMesh mesh;
};

/// Balls and boxes with faces missing, turned over and doubled. The boxes' corners and some edges are on rays.
std::vector<Holed> holed_meshes() {
  const TestMesh ball = ball_mesh({6, 6, 6}, 4.7, 3);
  const auto without = [](TestMesh mesh, auto dropped) {
    std::erase_if(mesh.faces, [&](const auto& f) {
      return dropped(Vec3d((mesh.vertices[f[0]] + mesh.vertices[f[1]] + mesh.vertices[f[2]]) / 3));
    });
    return mesh;
  };
  TestMesh box = box_mesh({2.25, 2.25, 2.1}, {9.75, 9.75, 9.9});
  box.faces.resize(10);
  TestMesh turned = ball;
  flip(turned, 30, 90);
  TestMesh doubled = ball;
  doubled.faces.insert(doubled.faces.end(), ball.faces.begin() + 100, ball.faces.begin() + 180);
  append(doubled, without(ball_mesh({6, 6, 6}, 2.9, 2), [](const Vec3d& p) { return p[1] > 7; }));
  return {{"no top", without(ball, [](const Vec3d& p) { return p[2] > 8; })},
          {"no side", without(ball, [](const Vec3d& p) { return p[0] > 8; })},
          {"two holes", without(ball, [](const Vec3d& p) { return std::abs(p[2] - 6) > 3; })},
          {"a box without its lid", box},
          {"turned faces", turned},
          {"doubled faces and a shell with a hole", doubled}};
}

TEST(RimWinding, IsThatOfAllTriangles) {
  for (const Holed& holed : holed_meshes()) {
    const auto triangles = on_lattice(holed.mesh);
    ArenaBlock arena(kMiB);
    auto edges = value_of(OpenEdges::create(*arena));
    for (const LatticeTriangle& t : triangles) ASSERT_TRUE(edges.add(t));
    ASSERT_TRUE(edges.begin_users());
    const Vec3d step = MeshLattice(kGrid, {}).step();
    const SmallHoles holes = value_of(close_small_holes(edges, step, 0, *arena));
    const MeshRim rim{holes.rim, step};
    ASSERT_TRUE(holes.caps.empty()) << holed.name;
    ASSERT_GT(rim.corners.size(), 3U) << holed.name;
    auto winding = value_of(RimWinding::create(rim, *arena));
    std::vector<RayHit> hits;
    for (const LatticeTriangle& t : triangles) {
      for_each_hit(t, kGrid, [&](const RayHit& hit) { hits.push_back(hit); });
    }
    for (std::uint32_t i = 0; i < kGrid.columns * kGrid.rows; ++i) {
      const std::uint32_t column = i % kGrid.columns;
      const std::uint32_t row = i / kGrid.columns;
      winding.begin(column, row);
      for (std::uint32_t layer = 0; layer < kGrid.layers; layer += 3) {
        int above = 0;
        for (const RayHit& hit : hits) {
          if (hit.column == column && hit.row == row && hit.height.layer() > layer) above += hit.entering ? -1 : 1;
        }
        const double z = (layer + 0.5) * 0.5;
        const WindingTurn turn = winding.at(static_cast<float>(z), above);
        const double found = turn.whole + std::atan2(static_cast<double>(turn.im), static_cast<double>(turn.re)) /
                                              (2 * std::numbers::pi);
        // A little beside the ray, as it is thought to be moved (EdgeFunction): some rays are on walls and edges.
        const double expected = winding_number(triangles, {(column + 0.5) * 0.5 + 1e-6, (row + 0.5) * 0.5 + 1e-9, z});
        ASSERT_NEAR(found, expected, 1e-4) << holed.name << " at " << column << ' ' << row << ' ' << layer;
        if (std::abs(expected - 0.5) > 1e-4) {
          EXPECT_EQ(turn.above_half(), expected > 0.5) << holed.name;
        }
        if (std::abs(expected - 0.1) > 1e-4 && std::abs(expected) < 1) {
          EXPECT_EQ(turn.above_tenth(), expected > 0.1) << holed.name;
        }
      }
    }
  }
}

TEST(BrokenMesh, ClosesALargeHoleAsRoundAsWhatIsLeft) {
  TestMesh mesh = ball_mesh({0, 0, 0}, 5, 5);
  SliceSettings settings = settings_with_pitch(0.1F);
  settings.base = BaseChoice::kNone;
  const double whole = sliced(mesh, settings).volume();
  std::erase_if(mesh.faces, [&](const auto& f) {
    return mesh.vertices[f[0]][0] + mesh.vertices[f[1]][0] + mesh.vertices[f[2]][0] > 3 * 3.5;
  });
  // A grain in the cap keeps the ball where it was.
  append(mesh, box_mesh({4.7, -0.3, -0.3}, {5, 0.3, 0.3}));
  const Slicing slicing = sliced(mesh, settings);
  EXPECT_FALSE(slicing.report().mesh->closed);
  // The cap is 6 % of the ball, a flat lid would lose all of it.
  EXPECT_NEAR(slicing.volume(), whole, 0.01 * whole);
  // No table of cells.
  EXPECT_LT(slicing.report().peak_bytes[static_cast<std::size_t>(Stage::kRays)], 2 * kMiB);
}

}  // namespace
}  // namespace plumbline
