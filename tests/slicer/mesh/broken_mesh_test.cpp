/// Meshes with holes, flipped and doubled faces, and faces that are no triangles.

#include <gtest/gtest.h>

#include "tests/slicer/mesh/sliced_mesh.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A box in a fine mesh, so that single faces are small.
TestMesh fine_box() {
  TestMesh mesh = box_mesh({0, 0, 0}, {10, 10, 10});
  for (int i = 0; i < 4; ++i) {
    TestMesh finer;
    for (const auto& [a, b, c] : mesh.faces) {
      const Vec3d va = mesh.vertices[a];
      const Vec3d vb = mesh.vertices[b];
      const Vec3d vc = mesh.vertices[c];
      const auto first = static_cast<std::uint32_t>(finer.vertices.size());
      finer.vertices.insert(finer.vertices.end(), {va, vb, vc, (va + vb) / 2, (vb + vc) / 2, (vc + va) / 2});
      for (const std::array<std::uint32_t, 3>& f :
           {std::array<std::uint32_t, 3>{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}) {
        finer.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
      }
    }
    mesh = finer;
  }
  return mesh;
}

struct Damage {
  const char* name;
  TestMesh mesh;
  double unsure;  ///< mm round the faces within which the result may differ
};

std::vector<Damage> damages() {
  const TestMesh whole = fine_box();
  const auto without = [&](auto dropped) {
    TestMesh mesh = whole;
    std::erase_if(mesh.faces, [&](const auto& f) {
      return dropped(Vec3d((whole.vertices[f[0]] + whole.vertices[f[1]] + whole.vertices[f[2]]) / 3));
    });
    return mesh;
  };
  const auto flipped = [&](auto chosen) {
    TestMesh mesh = whole;
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      const auto& f = mesh.faces[i];
      if (chosen(Vec3d((whole.vertices[f[0]] + whole.vertices[f[1]] + whole.vertices[f[2]]) / 3))) flip(mesh, i, i + 1);
    }
    return mesh;
  };
  const auto in_middle = [](const Vec3d& p) { return std::abs(p[0] - 5) < 1.3 && std::abs(p[1] - 5) < 1.3; };
  TestMesh doubled = whole;
  for (std::size_t i = 0; i < doubled.faces.size(); i += 3) doubled.faces.push_back(doubled.faces[i]);
  doubled.faces.resize(whole.faces.size() + 300);
  return {
      {"a hole in the top", without([&](const Vec3d& p) { return in_middle(p) && p[2] > 9; }), 0.5},
      {"a hole in the bottom", without([&](const Vec3d& p) { return in_middle(p) && p[2] < 1; }), 0.5},
      {"holes above each other", without([&](const Vec3d& p) { return in_middle(p) && (p[2] < 1 || p[2] > 9); }), 0.5},
      {"no top", without([&](const Vec3d& p) { return p[2] > 9.99; }), 2.5},
      {"a hole in a wall", without([&](const Vec3d& p) { return p[0] > 9.99 && std::abs(p[2] - 5) < 1.5; }), 0.5},
      {"flipped faces in the top", flipped([&](const Vec3d& p) { return in_middle(p) && p[2] > 9; }), 0.5},
      {"flipped faces in top and bottom",
       flipped([&](const Vec3d& p) { return in_middle(p) && std::abs(p[2] - 5) > 4; }), 0.5},
      {"doubled faces", doubled, 0.5}};
}

std::vector<bool> voxels(const Slicing& slicing) {
  std::vector<bool> all;
  slicing.for_each_section([&](std::uint32_t, ConstBitImage section) {
    for (std::uint32_t r = 0; r < slicing.grid().rows; ++r) {
      for (std::uint32_t c = 0; c < slicing.grid().columns; ++c) all.push_back(section.at(c, r));
    }
  });
  return all;
}

TEST(BrokenMesh, IsDecidedByItsWindingNumber) {
  SliceSettings settings = settings_with_pitch(0.2F);
  settings.base = BaseChoice::kNone;
  for (const Damage& damage : damages()) {
    const Slicing broken = sliced(damage.mesh, settings);
    // Only where there is damage can the surface be off.
    EXPECT_EQ(wrong(broken,
                    [&](const Vec3d& p) {
                      return in_box(p, {0, 0, 0}, {10, 10, 10}, damage.unsure);
                    }),
              0U)
        << damage.name;
    EXPECT_NEAR(broken.volume(), 1000, damage.unsure > 1 ? 110 : 12) << damage.name;
  }
}

TEST(BrokenMesh, AsksTheWindingNumberOnFewRaysWhereTheyAreAlike) {
  TestMesh mesh = fine_box();
  std::erase_if(mesh.faces, [&](const auto& f) {
    return mesh.vertices[f[0]][2] + mesh.vertices[f[1]][2] + mesh.vertices[f[2]][2] > 29.99;
  });
  SliceSettings settings = settings_with_pitch(0.1F);
  settings.base = BaseChoice::kNone;
  const Slicing slicing = sliced(mesh, settings);
  const MeshCounts& counts = *slicing.report().mesh;
  EXPECT_EQ(counts.decided_rays, 10000U);
  EXPECT_LT(counts.asked_rays, 1600U);
  // Near the walls they are asked one by one, and say the same.
  EXPECT_EQ(wrong(slicing, [&](const Vec3d& p) { return in_box(p, {0, 0, 0}, {10, 10, 10}, 0.2); }), 0U);
}

TEST(BrokenMesh, TurnedFacesAreNoDamageWhereSolidsLieApart) {
  // A box with a hollow, and one above it. An eighth of the faces is large here, so no winding number could tell.
  const auto object = [](auto turn) {
    TestMesh mesh = box_mesh({0, 0, 0}, {10, 10, 4});
    TestMesh hollow = box_mesh({2, 2, 1}, {9, 9, 3});
    flip(hollow, 0, hollow.faces.size());
    append(mesh, hollow);
    append(mesh, box_mesh({1, 1, 6}, {8, 8, 10}));
    turn(mesh);
    return mesh;
  };
  SliceSettings settings = settings_with_pitch(0.2F);
  settings.base = BaseChoice::kNone;
  const auto inside = [](const Vec3d& p) {
    if (in_box(p, {2, 2, 1}, {9, 9, 3}) > 0) return -1;
    return std::max(in_box(p, {0, 0, 0}, {10, 10, 4}), in_box(p, {1, 1, 6}, {8, 8, 10}));
  };
  for (const std::size_t face : {0U, 11U, 12U, 22U, 24U, 35U}) {
    const Slicing slicing = sliced(object([&](TestMesh& mesh) { flip(mesh, face, face + 1); }), settings);
    const MeshCounts& counts = *slicing.report().mesh;
    EXPECT_TRUE(counts.closed);
    EXPECT_EQ(counts.turned, 1U);
    EXPECT_EQ(counts.broken_rays, 0U);
    EXPECT_EQ(wrong(slicing, inside), 0U) << "face " << face;
  }
}

TEST(BrokenMesh, DoubledFacesAreNoDamage) {
  TestMesh mesh = box_mesh({0, 0, 0}, {10, 10, 10});
  append(mesh, box_mesh({2, 2, 2}, {8, 8, 8}));
  for (const std::size_t face : {0U, 11U, 12U, 23U}) mesh.faces.push_back(mesh.faces[face]);
  const Slicing slicing = sliced(mesh, settings_with_pitch(0.2F));
  EXPECT_TRUE(slicing.report().mesh->closed);
  EXPECT_EQ(slicing.report().mesh->dropped, 4U);
  EXPECT_EQ(slicing.report().mesh->broken_rays, 0U);
  EXPECT_EQ(wrong(slicing, [](const Vec3d& p) { return in_box(p, {0, 0, 0}, {10, 10, 10}); }), 0U);
}

TEST(BrokenMesh, DoubledFacesDoNotFillTheGapBetweenPlates) {
  // With half of the upper plate's top there four times, the winding number in the gap is that of a solid.
  TestMesh mesh = box_mesh({0, 0, 0}, {30, 30, 1});
  append(mesh, box_mesh({0, 0, 5}, {30, 30, 6}));
  for (const std::size_t face : {22U, 22U, 22U, 23U}) mesh.faces.push_back(mesh.faces[face]);
  const Slicing slicing = sliced(mesh, settings_with_pitch(0.5F));
  EXPECT_EQ(wrong(slicing,
                  [](const Vec3d& p) {
                    return std::max(in_box(p, {0, 0, 0}, {30, 30, 1}), in_box(p, {0, 0, 5}, {30, 30, 6}));
                  }),
            0U);
}

TEST(BrokenMesh, IsWholeAgainWhereSingleFacesAreMissingDoubledOrTurnedOver) {
  // A shell in a ball, so that directions count. Its faces are a millimetre long: no winding number could tell to a pixel.
  const TestMesh whole = [] {
    TestMesh mesh = ball_mesh({0, 0, 10}, 10, 3);
    TestMesh inner = ball_mesh({1, 0, 10}, 6, 3);
    append(mesh, inner);
    return mesh;
  }();
  SliceSettings settings = settings_with_pitch(0.2F);
  settings.base = BaseChoice::kNone;
  const Slicing undamaged = sliced(whole, settings);
  ASSERT_TRUE(undamaged.report().mesh->closed);
  for (const char* damage : {"missing", "doubled", "turned over", "all of them"}) {
    TestMesh mesh = whole;
    const std::string kind = damage;
    const bool all = kind == "all of them";
    for (std::size_t i = 5; i + 80 < whole.faces.size(); i += 80) {
      if (all || kind == "doubled") mesh.faces.push_back(whole.faces[i]);
      if (all || kind == "turned over") flip(mesh, i + 30, i + 31);
    }
    for (const std::size_t i : {63U, 400U}) {
      if (all || kind == "missing") std::erase(mesh.faces, whole.faces[i]);
    }
    const Slicing slicing = sliced(mesh, settings);
    const MeshCounts& counts = *slicing.report().mesh;
    const auto some = [](bool yes) { return yes ? 12U : 0U; };
    EXPECT_EQ(counts.closed, !(all || kind == "missing")) << damage;
    EXPECT_EQ(counts.turned, some(all || kind == "turned over")) << damage;
    EXPECT_EQ(counts.dropped, some(all || kind == "doubled")) << damage;
    EXPECT_EQ(counts.closed_holes, all || kind == "missing" ? 2U : 0U) << damage;
    EXPECT_EQ(counts.decided_rays, 0U) << damage;
    EXPECT_EQ(voxels(slicing), voxels(undamaged)) << damage;
  }
}

TEST(BrokenMesh, KeepsLoneTrianglesWhoseCornersDoNotMeet) {
  // Some faces are shrunk by a thousandth: their rims are loops like those of holes.
  const TestMesh whole = fine_box();
  TestMesh mesh = whole;
  for (const std::size_t first : {0U, 100U, 400U, 1000U, 2000U, 2004U, 2900U}) {
    Vec3d middle = Vec3d::Zero();
    for (const std::uint32_t corner : whole.faces[first]) middle += whole.vertices[corner] / 3;
    for (std::uint32_t& corner : mesh.faces[first]) {
      mesh.vertices.push_back(middle + (whole.vertices[corner] - middle) * 0.999);
      corner = static_cast<std::uint32_t>(mesh.vertices.size()) - 1;
    }
  }
  SliceSettings settings = settings_with_pitch(0.2F);
  settings.base = BaseChoice::kNone;
  const Slicing slicing = sliced(mesh, settings);
  EXPECT_FALSE(slicing.report().mesh->closed);
  EXPECT_EQ(wrong(slicing, [](const Vec3d& p) { return in_box(p, {0, 0, 0}, {10, 10, 10}, 0.3); }), 0U);
}

TEST(BrokenMesh, TurnedFacesAreNoDamageWhereSolidsLieInEachOther) {
  TestMesh mesh = fine_box();
  append(mesh, box_mesh({2, 2, 2}, {8, 8, 8}));
  flip(mesh, 100, 101);
  const Slicing slicing = sliced(mesh, settings_with_pitch(0.2F));
  EXPECT_EQ(slicing.report().mesh->turned, 1U);
  EXPECT_EQ(wrong(slicing, [](const Vec3d& p) { return in_box(p, {0, 0, 0}, {10, 10, 10}); }), 0U);
}

TEST(BrokenMesh, LeavesOutAndCountsTrianglesThatAreNotFinite) {
  TestMesh mesh = fine_box();
  const std::uint32_t corner = mesh.faces[1500][1];
  mesh.vertices[corner][0] = std::numeric_limits<double>::quiet_NaN();
  for (const SurfaceFile& file : {files_of(mesh)[0], files_of(mesh)[5]}) {
    const Slicing slicing(MemorySource(file.bytes, file.name), settings_with_pitch(0.2F), kArena);
    EXPECT_GE(slicing.report().mesh->not_finite, 1U) << file.name;
    EXPECT_LE(slicing.report().mesh->not_finite, 6U) << file.name;
    EXPECT_NEAR(slicing.volume(), 1000, 5) << file.name;
  }
}

}  // namespace
}  // namespace plumbline
