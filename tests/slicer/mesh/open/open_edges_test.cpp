#include "slicer/mesh/open/open_edges.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <utility>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(OpenEdges, AreThoseThatRunMoreOftenOneWayHoweverManyAreOpenMeanwhile) {
  std::mt19937 random(1);
  const auto corner = [&] {
    const auto place = [&] { return static_cast<std::int32_t>(random() % 40); };
    return LatticePoint{place(), place(), place()};
  };
  std::vector<LatticeTriangle> triangles;
  for (int i = 0; i < 20'000; ++i) triangles.push_back({corner(), corner(), corner()});
  // All but some are there a second time, turned over.
  for (std::size_t i = 0; i < 19'900; ++i) triangles.push_back({triangles[i][0], triangles[i][2], triangles[i][1]});
  std::map<std::pair<LatticePoint, LatticePoint>, int> expected;
  for (const LatticeTriangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const LatticePoint from = t[i], to = t[(i + 1) % 3];
      if (from < to) ++expected[{from, to}];
      if (to < from) --expected[{to, from}];
    }
  }
  std::erase_if(expected, [](const auto& edge) { return edge.second == 0; });

  ArenaBlock arena(64 * kMiB);
  auto edges = *OpenEdges::create(*arena);
  for (const LatticeTriangle& t : triangles) ASSERT_TRUE(edges.add(t).has_value());
  ASSERT_FALSE(edges.full());
  ASSERT_TRUE(edges.begin_users().has_value());
  EXPECT_EQ(edges.size(), expected.size());
  edges.for_each([&](const OpenEdge& edge, const EdgeUsers&) {
    const auto found = expected.find({edge.low, edge.high});
    ASSERT_NE(found, expected.end());
    EXPECT_EQ(edge.surplus, found->second);
    expected.erase(found);
  });
  EXPECT_TRUE(expected.empty());
}

}  // namespace
}  // namespace plumbline
