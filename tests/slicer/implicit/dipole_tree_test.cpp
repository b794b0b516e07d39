#include "slicer/implicit/dipole_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr std::uint32_t kLeaf = 4;
using Tree = DipoleTree<kLeaf>;

/// Each point is one dipole of length 1 along x, so that a walk can count points.
struct Counted {
  std::vector<Vec3f> points;
  std::vector<bool> in_field;
  std::vector<DipoleNode> nodes;
  Tree tree;

  Counted(std::uint32_t size, double share, std::uint32_t left_out_from, std::uint32_t left_out_to) {
    Random random(61);
    for (std::uint32_t i = 0; i < size; ++i) {
      // Along a line, so that consecutive points are neighbours.
      points.emplace_back((Vec3d(i * 0.1, 0, 0) + 0.2 * random.vector()).cast<float>());
      in_field.push_back((i < left_out_from || i >= left_out_to) && random.uniform(0, 1) < share);
    }
    nodes.resize(Tree::nodes_needed(size));
    tree = Tree(size, nodes);
    tree.build([&](std::uint32_t i, DipoleSum& sum) {
      if (in_field[i]) sum.add(points[i], 1, Vec3f(1, 0, 0));
    });
  }
  std::uint32_t total() const { return static_cast<std::uint32_t>(std::count(in_field.begin(), in_field.end(), true)); }
};

TEST(DipoleTree, CountsEveryPointOnceFromEveryPlace) {
  for (const std::uint32_t size : {1U, kLeaf, kLeaf + 1, 7U, 64U, 1001U}) {
    for (const double share : {1.0, 0.3}) {
      const Counted counted(size, share, size / 4, size / 2);  // some leaves and nodes have no point
      Random random(62);
      for (int n = 0; n < 50; ++n) {
        const Vec3f x(static_cast<float>(random.uniform(-5, 0.1 * size + 5)), static_cast<float>(random.uniform(-3, 3)),
                      0);
        float far = 0;
        std::vector<int> near(size, 0);
        counted.tree.walk(
            x, [&](const DipoleNode& node) { far += node.dipole[0]; }, [&](std::uint32_t i) { ++near[i]; });
        float seen = far;
        for (std::uint32_t i = 0; i < size; ++i) {
          ASSERT_LE(near[i], 1);
          if (counted.in_field[i]) seen += static_cast<float>(near[i]);
        }
        ASSERT_EQ(seen, static_cast<float>(counted.total())) << size << " points, from " << x.transpose();
      }
    }
  }
}

TEST(DipoleTree, SumsNoPointThatIsCloserThanItsLeafIsWide) {
  const Counted counted(1000, 1, 0, 0);
  std::vector<float> half_width;  // for each point, half the largest distance between two points of its leaf
  for (std::uint32_t i = 0; i < counted.points.size(); ++i) {
    const std::uint32_t first = i / kLeaf * kLeaf;
    float widest = 0;
    for (std::uint32_t a = first; a < first + kLeaf; ++a) {
      for (std::uint32_t b = first; b < a; ++b)
        widest = std::max(widest, (counted.points[a] - counted.points[b]).norm());
    }
    half_width.push_back(widest / 2);
  }
  Random random(63);
  std::size_t taken = 0;
  std::size_t close = 0;
  for (int n = 0; n < 200; ++n) {
    const Vec3f x = counted.points[random.below(1000)] + (0.2 * random.vector()).cast<float>();
    std::vector<bool> near(counted.points.size(), false);
    counted.tree.walk(
        x, [&](const DipoleNode&) { ++taken; }, [&](auto i) { near[i] = true; });
    for (std::size_t i = 0; i < near.size(); ++i) {
      if ((counted.points[i] - x).norm() >= half_width[i]) continue;
      ++close;
      EXPECT_TRUE(near[i]) << i;
    }
  }
  EXPECT_GT(close, 200U);
  EXPECT_LT(taken, 200U * counted.points.size() / 10) << "nothing is gained over the sum of all points";
}

TEST(DipoleTree, VisitsNothingWithoutPoints) {
  EXPECT_EQ(Tree::nodes_needed(0), 0U);
  Tree tree(0, {});
  tree.build([](std::uint32_t, DipoleSum&) { FAIL(); });
  tree.walk(
      Vec3f::Zero().eval(), [](const DipoleNode&) { FAIL(); }, [](std::uint32_t) { FAIL(); });
}

}  // namespace
}  // namespace plumbline
