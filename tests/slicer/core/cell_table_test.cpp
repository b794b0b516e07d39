#include "slicer/core/cell_table.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;
using CellNumber = std::array<int, 3>;

constexpr float kEdge = 0.5F;  // a power of two, so that the oracle's division rounds in the same way

struct Points {
  Box3f box;
  std::vector<Vec3f> positions;
  CellNumber cell_of(const Vec3f& p) const {
    CellNumber cell;
    for (int axis = 0; axis < 3; ++axis) {
      cell[static_cast<std::size_t>(axis)] = static_cast<int>(std::floor((p[axis] - box.low[axis]) / kEdge));
    }
    return cell;
  }
};

Points random_points(std::size_t count, double extent) {
  Random random(5);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d p(random.uniform(-extent, extent), random.uniform(-extent, extent), random.uniform(-extent, extent));
    points.positions.emplace_back(p.cast<float>());
    points.box.extend(points.positions.back());
  }
  return points;
}

TEST(CellGrid, GivesTwoPointsOneKeyExactlyWhenTheyShareACell) {
  const Points points = random_points(2000, 2);
  const CellGrid grid(points.box, kEdge);
  std::map<CellNumber, std::uint64_t> key_of_cell;
  std::set<std::uint64_t> keys;
  for (const Vec3f& p : points.positions) {
    const std::uint64_t key = grid.key(p);
    EXPECT_NE(key, 0U);
    keys.insert(key);
    const auto [entry, fresh] = key_of_cell.emplace(points.cell_of(p), key);
    EXPECT_EQ(entry->second, key);
  }
  EXPECT_EQ(keys.size(), key_of_cell.size());
}

TEST(CellGrid, ReachesEachPairOfNeighboursOnceFromTheUpperHalf) {
  const Points points = random_points(4000, 1);
  const CellGrid grid(points.box, kEdge);
  std::map<std::uint64_t, CellNumber> cells;
  for (const Vec3f& p : points.positions) cells.emplace(grid.key(p), points.cell_of(p));
  using Pair = std::set<std::uint64_t>;
  std::multiset<Pair> reached;
  std::multiset<Pair> expected;
  for (const auto& [key, cell] : cells) {
    EXPECT_EQ(CellGrid::neighbour(key, 13), key);
    for (std::uint32_t n = 14; n < 27; ++n) {
      const std::uint64_t other = CellGrid::neighbour(key, n);
      if (cells.contains(other)) reached.insert({key, other});
    }
    for (const auto& [other_key, other] : cells) {
      int farthest = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) farthest = std::max(farthest, std::abs(cell[axis] - other[axis]));
      if (key < other_key && farthest == 1) expected.insert({key, other_key});
    }
  }
  EXPECT_FALSE(expected.empty());
  EXPECT_EQ(reached, expected);
}

TEST(CellGrid, EnlargesCellsThatAreTooManyForAKey) {
  Box3f box;
  box.extend(Vec3f(0, 0, 0));
  box.extend(Vec3f(1e6F, 1, 1));
  const CellGrid grid(box, 1e-6F);
  std::uint64_t before = 0;
  for (const float x : {0.0F, 1e5F, 5e5F, 9e5F, 1e6F}) {
    const std::uint64_t key = grid.key(Vec3f(x, 1, 1));
    EXPECT_GT(key, before);
    before = key;
  }
  EXPECT_LT(before >> 2 * CellGrid::kBitsPerAxis, CellGrid::kMostCells);
}

TEST(CellTable, CountsPointsOfCellsAsAMapDoes) {
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t points = 0;
  };
  const Points points = random_points(1000, 3);
  const CellGrid grid(points.box, kEdge);
  std::map<std::uint64_t, std::uint32_t> expected;
  std::vector<Slot> slots(2048, Slot{7, 7});
  const CellTable<Slot, &Slot::key> table{std::span(slots)};
  table.clear();
  for (const Vec3f& p : points.positions) {
    const std::uint64_t key = grid.key(p);
    ++expected[key];
    const std::uint32_t at = table.find_key(key);
    table[at].key = key;
    ++table[at].points;
  }
  std::map<std::uint64_t, std::uint32_t> found;
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    if (table.occupied(i)) found.emplace(table[i].key, table[i].points);
  }
  EXPECT_EQ(found, expected);
}

TEST(CellTable, ProbesPastTheEndWhenAllHashesCollide) {
  std::vector<std::uint32_t> slots(8);
  const CellTable<std::uint32_t> table{std::span(slots)};
  table.clear();
  const auto find = [&](std::uint32_t value) {
    return table.find(6, [value](std::uint32_t slot) { return slot == value; });
  };
  const std::array<std::uint32_t, 7> expected_slots{6, 7, 0, 1, 2, 3, 4};
  for (std::uint32_t value = 1; value <= 7; ++value) {
    EXPECT_EQ(find(value), expected_slots[value - 1]);
    table[find(value)] = value;
  }
  for (std::uint32_t value = 1; value <= 7; ++value) EXPECT_EQ(table[find(value)], value);
  EXPECT_FALSE(table.occupied(find(8)));
}

}  // namespace
}  // namespace plumbline
