#include "slicer/core/disjoint_sets.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

Pairs random_pairs(std::uint32_t members, std::size_t count, std::uint32_t seed) {
  Random random(seed);
  Pairs pairs(count);
  for (auto& [a, b] : pairs) {
    a = random.below(members);
    b = random.below(members);
  }
  return pairs;
}

/// By brute force: every member has the lowest index of its set as its label.
std::vector<std::uint32_t> lowest_of_sets(std::uint32_t members, const Pairs& pairs) {
  std::vector<std::uint32_t> label(members);
  for (std::uint32_t i = 0; i < members; ++i) label[i] = i;
  for (const auto& [a, b] : pairs) {
    const std::uint32_t low = std::min(label[a], label[b]);
    const std::uint32_t high = std::max(label[a], label[b]);
    std::replace(label.begin(), label.end(), high, low);
  }
  return label;
}

template <class Sets>
std::vector<std::uint32_t> roots_of(const Sets& sets) {
  std::vector<std::uint32_t> roots;
  for (std::uint32_t i = 0; i < sets.size(); ++i) roots.push_back(sets.root(i));
  return roots;
}

TEST(DisjointSets, HaveTheLowestIndexAsTheirRoot) {
  constexpr std::uint32_t kMembers = 300;
  for (const std::size_t unions : {0U, 1U, 100U, 250U, 1000U}) {
    const Pairs pairs = random_pairs(kMembers, unions, 1);
    std::vector<std::uint32_t> parents(kMembers);
    DisjointSets sets{std::span(parents)};
    sets.start_all();
    for (const auto& [a, b] : pairs) sets.unite(a, b);
    const std::vector<std::uint32_t> expected = lowest_of_sets(kMembers, pairs);
    EXPECT_EQ(roots_of(sets), expected) << unions << " unions";
    for (std::uint32_t i = 0; i < kMembers; ++i) EXPECT_EQ(sets.is_root(i), expected[i] == i) << i;
  }
}

TEST(DisjointSets, SayWhichRootAUnionAbsorbed) {
  std::vector<std::uint32_t> parents(6);
  DisjointSets sets{std::span(parents)};
  sets.start_all();
  const auto expect = [](auto joined, std::uint32_t root, std::uint32_t absorbed) {
    EXPECT_EQ(joined.root, root);
    EXPECT_EQ(joined.absorbed, absorbed);
  };
  expect(sets.unite(4, 2), 2, 4);
  expect(sets.unite(5, 4), 2, 5);
  expect(sets.unite(1, 5), 1, 2);
  expect(sets.unite(4, 5), 1, 1);
}

TEST(DisjointSets, PointToTheirRootsOnceTheyAreFlat) {
  constexpr std::uint32_t kMembers = 300;
  const Pairs pairs = random_pairs(kMembers, 200, 3);
  std::vector<std::uint32_t> parents(kMembers);
  DisjointSets sets{std::span(parents)};
  sets.start_all();
  for (const auto& [a, b] : pairs) sets.unite(a, b);
  sets.flatten(kMembers);
  EXPECT_EQ(parents, lowest_of_sets(kMembers, pairs));
}

TEST(DisjointSets, CanKeepParentsInAMemberOfTheirEntries) {
  struct Entry {
    float other = 1;
    std::uint32_t parent = 0;
  };
  constexpr std::uint32_t kMembers = 100;
  const Pairs pairs = random_pairs(kMembers, 80, 4);
  std::vector<Entry> entries(kMembers);
  DisjointSets<Entry, &Entry::parent> sets{std::span(entries)};
  for (std::uint32_t i = 0; i < kMembers; ++i) sets.start(i);
  for (const auto& [a, b] : pairs) sets.unite(a, b);
  EXPECT_EQ(roots_of(sets), lowest_of_sets(kMembers, pairs));
  for (const Entry& entry : entries) EXPECT_EQ(entry.other, 1);
}

}  // namespace
}  // namespace plumbline
