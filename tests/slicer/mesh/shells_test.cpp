/// Which way the shells of a mesh face, whatever their faces say.

#include <gtest/gtest.h>

#include "tests/slicer/mesh/sliced_mesh.hpp"

namespace plumbline {
namespace {

using namespace testing;

TestMesh inside_out(TestMesh mesh) {
  flip(mesh, 0, mesh.faces.size());
  return mesh;
}

TestMesh joined(const std::vector<TestMesh>& meshes) {
  TestMesh all;
  for (const TestMesh& mesh : meshes) append(all, mesh);
  return all;
}

/// Turns a share of the faces over.
TestMesh some_turned(TestMesh mesh, double share, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    if (static_cast<double>(random() % 1000) < share * 1000) flip(mesh, i, i + 1);
  }
  return mesh;
}

/// All sections, as their words.
std::vector<std::uint64_t> masks(const TestMesh& mesh) {
  SliceSettings settings = settings_with_pitch(0.25F);
  settings.base = BaseChoice::kNone;
  std::vector<std::uint64_t> words;
  sliced(mesh, settings).for_each_section([&](std::uint32_t, ConstBitImage section) {
    words.insert(words.end(), section.words().begin(), section.words().end());
  });
  return words;
}

const TestMesh kBall = ball_mesh({0, 0, 8}, 8, 4);
const TestMesh kOther = ball_mesh({9, 1, 8}, 7, 4);
const TestMesh kThird = ball_mesh({3, 9, 7}, 6, 4);
const TestMesh kInner = ball_mesh({1, 0, 8}, 5, 4);
const TestMesh kInnermost = ball_mesh({1, 0, 8}, 2.5, 3);

TEST(Shells, AreFoundWhateverShareOfTheirFacesIsTurnedOver) {
  const auto right = masks(kBall);
  for (const double share : {0.003, 0.05, 0.3, 0.5, 1.0}) {
    EXPECT_EQ(masks(shuffled(some_turned(kBall, share, 1), 2)), right) << share;
  }
}

TEST(Shells, ThatOverlapAreOneSolidWhicheverIsInsideOut) {
  const auto right = masks(joined({kBall, kOther, kThird}));
  for (std::uint32_t which = 0; which < 8; ++which) {
    const auto one = [&](std::uint32_t i, const TestMesh& mesh) {
      return some_turned((which >> i & 1U) != 0 ? inside_out(mesh) : mesh, 0.1, i);
    };
    EXPECT_EQ(masks(shuffled(joined({one(0, kBall), one(1, kOther), one(2, kThird)}), which)), right) << which;
  }
}

TEST(Shells, ThatFaceIntoAnotherAreHollows) {
  for (const double share : {0.0, 0.2}) {
    const auto hollow = masks(joined({kBall, inside_out(kInner)}));
    const auto turned = [&](const std::vector<TestMesh>& meshes) {
      return masks(shuffled(some_turned(joined(meshes), share, 3), 4));
    };
    EXPECT_NE(hollow, masks(kBall));
    EXPECT_EQ(turned({kBall, inside_out(kInner)}), hollow);
    EXPECT_EQ(turned({inside_out(kBall), kInner}), hollow);
    EXPECT_EQ(turned({kBall, kInner}), masks(kBall));
    EXPECT_EQ(turned({inside_out(kBall), inside_out(kInner)}), masks(kBall));
    const auto kernel = masks(joined({kBall, inside_out(kInner), kInnermost}));
    EXPECT_EQ(turned({kBall, inside_out(kInner), kInnermost}), kernel);
    EXPECT_EQ(turned({kBall, inside_out(kInner), inside_out(kInnermost)}), kernel);
    const auto both = masks(joined({kBall, inside_out(kInner), kOther}));
    EXPECT_EQ(turned({kBall, inside_out(kInner), inside_out(kOther)}), both);
    EXPECT_EQ(turned({inside_out(kBall), kInner, kOther}), both);
  }
}

TEST(Shells, OfStackedBoxesHaveNoFaceBetweenThem) {
  const TestMesh below = box_mesh({0, 0, 0}, {10, 10, 5});
  const TestMesh above = box_mesh({0, 0, 5}, {10, 10, 9});
  TestMesh mirrored = above;  // whose faces have the other diagonals
  for (Vec3d& v : mirrored.vertices) v[0] = 10 - v[0];
  flip(mirrored, 0, mirrored.faces.size());
  const auto right = masks(box_mesh({0, 0, 0}, {10, 10, 9}));
  for (const TestMesh& other : {above, mirrored}) {
    EXPECT_EQ(masks(joined({below, other})), right);
    EXPECT_EQ(masks(joined({inside_out(below), other})), right);
    for (const std::size_t face : {0U, 10U, 11U, 12U, 13U, 20U}) {
      TestMesh mesh = joined({below, other});
      flip(mesh, face, face + 1);
      EXPECT_EQ(masks(mesh), right) << face;
    }
  }
}

TEST(Shells, HaveEachFaceOnce) {
  const auto right = masks(kBall);
  TestMesh half = kBall;
  half.faces.resize(half.faces.size() / 2);
  for (const TestMesh& more : {kBall, half, inside_out(kBall), inside_out(half)}) {
    EXPECT_EQ(masks(joined({kBall, more})), right);
    EXPECT_EQ(masks(shuffled(some_turned(joined({kBall, more}), 0.1, 5), 6)), right);
  }
  EXPECT_EQ(masks(joined({kBall, inside_out(kBall), inside_out(kInner)})), masks(joined({kBall, inside_out(kInner)})));
}

TEST(Shells, AreJoinedInPartsWhereTheArenaIsSmall) {
  const TestMesh fine = ball_mesh({0, 0, 8}, 8, 7);
  const TestMesh mesh = some_turned(fine, 0.3, 7);
  const auto hashes = [](const TestMesh& m, std::size_t arena) {
    const Slicing slicing(MemorySource(binary_stl(m), "mesh.stl"), settings_with_pitch(0.5F), arena);
    EXPECT_TRUE(slicing.report().mesh->closed);
    return slicing.volume();
  };
  EXPECT_EQ(hashes(mesh, std::size_t{1} << 22U), hashes(fine, kArena));
}

}  // namespace
}  // namespace plumbline
