#include "slicer/mesh/triangle_rays.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>
#include <vector>

#include "slicer/mesh/edge_sum.hpp"
#include "slicer/mesh/hit_list.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/meshes.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A whole number of 192 bits in two's complement: room for every product and sum here, on every machine.
class Wide {
 public:
  Wide(std::int64_t value = 0) {  // NOLINT(google-explicit-constructor): a number
    limb_[0] = static_cast<std::uint32_t>(value);
    limb_[1] = static_cast<std::uint32_t>(static_cast<std::uint64_t>(value) >> 32U);
    for (std::size_t i = 2; i < kLimbs; ++i) limb_[i] = value < 0 ? 0xFFFFFFFFU : 0;
  }
  friend Wide operator+(const Wide& a, const Wide& b) {
    Wide sum;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < kLimbs; ++i) {
      carry += std::uint64_t{a.limb_[i]} + b.limb_[i];
      sum.limb_[i] = static_cast<std::uint32_t>(carry);
      carry >>= 32U;
    }
    return sum;
  }
  friend Wide operator*(const Wide& a, const Wide& b) {
    Wide product;
    for (std::size_t i = 0; i < kLimbs; ++i) {
      std::uint64_t carry = 0;
      for (std::size_t j = 0; i + j < kLimbs; ++j) {
        carry += std::uint64_t{a.limb_[i]} * b.limb_[j] + product.limb_[i + j];
        product.limb_[i + j] = static_cast<std::uint32_t>(carry);
        carry >>= 32U;
      }
    }
    return product;
  }
  friend Wide operator-(const Wide& a, const Wide& b) { return a + b * Wide(-1); }
  int sign() const {
    if (limb_[kLimbs - 1] >> 31U != 0) return -1;
    for (const std::uint32_t limb : limb_) {
      if (limb != 0) return 1;
    }
    return 0;
  }

 private:
  static constexpr std::size_t kLimbs = 6;
  std::array<std::uint32_t, kLimbs> limb_{};
};

/// Sign of the area of (a, b, p) where p is moved by (d, d^2), and its area without that.
std::pair<int, Wide> side(const LatticePoint& a, const LatticePoint& b, std::int64_t x, std::int64_t y) {
  const Wide dx = Wide(b.x) - a.x;
  const Wide dy = Wide(b.y) - a.y;
  const Wide area = dx * (Wide(y) - a.y) - dy * (Wide(x) - a.x);
  // A polynomial in d: area - dy d + dx d^2. Its first term that is not 0 decides.
  for (const Wide& term : {area, dy * Wide(-1), dx}) {
    if (term.sign() != 0) return {term.sign(), area};
  }
  return {0, area};
}

using Hit = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, bool>;  // row, column, layer, entering

/// Tries every ray and every layer, in wide numbers.
std::vector<Hit> hits_by_definition(const LatticeTriangle& t, const PrintGrid& grid, std::uint32_t first_column,
                                    std::uint32_t end_column, std::uint32_t first_row, std::uint32_t end_row,
                                    std::uint32_t first_layer) {
  std::vector<Hit> hits;
  for (std::uint32_t row = first_row; row < end_row; ++row) {
    for (std::uint32_t column = first_column; column < end_column; ++column) {
      const std::int64_t x = column * kPixelSteps + kPixelSteps / 2;
      const std::int64_t y = row * kPixelSteps + kPixelSteps / 2;
      const auto [s0, w0] = side(t[1], t[2], x, y);
      const auto [s1, w1] = side(t[2], t[0], x, y);
      const auto [s2, w2] = side(t[0], t[1], x, y);
      if (s0 == 0 || s0 != s1 || s1 != s2) continue;
      std::uint32_t layer = first_layer;
      for (; layer < grid.layers; ++layer) {
        const std::int64_t height = layer * kLayerSteps + kLayerSteps / 2;
        const Wide above = w0 * (Wide(t[0].z) - height) + w1 * (Wide(t[1].z) - height) + w2 * (Wide(t[2].z) - height);
        if (above.sign() * s0 <= 0) break;
      }
      hits.emplace_back(row, column, layer, s0 < 0);
    }
  }
  return hits;
}

std::vector<Hit> hits_of(const LatticeTriangle& t, const PrintGrid& grid) {
  std::vector<Hit> hits;
  for_each_hit(t, grid, [&](const RayHit& h) { hits.emplace_back(h.row, h.column, h.height.layer(), h.entering); });
  return hits;
}

TEST(TriangleRays, AreThoseOfTheDefinitionForTrianglesOnPixelCentresAndSamplingHeights) {
  const PrintGrid grid{.columns = 9, .rows = 7, .layers = 6};
  std::mt19937 random(1);
  // Coordinates in quarters of a pixel and of a layer: most tests are ties.
  const auto any = [&](std::uint32_t cells, std::int64_t steps) {
    return static_cast<std::int32_t>(static_cast<std::int64_t>(random() % (4 * cells + 1)) * (steps / 4));
  };
  std::size_t hits = 0;
  for (int i = 0; i < 4000; ++i) {
    LatticeTriangle t;
    for (LatticePoint& p : t) p = {any(9, kPixelSteps), any(7, kPixelSteps), any(6, kLayerSteps)};
    const auto found = hits_of(t, grid);
    ASSERT_EQ(found, hits_by_definition(t, grid, 0, 9, 0, 7, 0)) << "triangle " << i;
    hits += found.size();
  }
  EXPECT_GT(hits, 10'000U);
}

TEST(TriangleRays, AreThoseOfTheDefinitionInTheLargestGrid) {
  const PrintGrid grid{.columns = PrintGrid::kMaxSide, .rows = PrintGrid::kMaxSide, .layers = PrintGrid::kMaxLayers};
  constexpr std::int32_t kFar = std::int32_t{1} << 30;
  constexpr std::int32_t kHigh = static_cast<std::int32_t>(PrintGrid::kMaxLayers * kLayerSteps);
  // Thin triangles from corner to corner of the grid: the largest products there are.
  const LatticeTriangle t = {{{0, 0, 0}, {kFar, kFar, kHigh}, {1 << 18, 3 << 17, kHigh / 2}}};
  std::map<std::uint32_t, std::vector<Hit>> by_row;
  for (const Hit& hit : hits_of(t, grid)) by_row[std::get<0>(hit)].push_back(hit);
  EXPECT_GT(by_row.size(), 8000U);
  for (const std::uint32_t row : {0U, 3U, 77U, 8191U, 16000U, 16383U}) {
    const auto all = hits_by_definition(t, grid, row < 8 ? 0 : row - 8, std::min(row + 8, grid.columns), row, row + 1,
                                        row < 8000 ? 0 : 4 * row - 20);
    EXPECT_EQ(by_row[row], all) << "row " << row;
  }
}

TEST(TriangleRays, LongSliversCostTheirRowsNotTheirBox) {
  const PrintGrid grid{.columns = 64, .rows = 50, .layers = 40};
  std::mt19937 random(2);
  for (int i = 0; i < 300; ++i) {
    LatticeTriangle t;
    for (LatticePoint& p : t) {
      p = {static_cast<std::int32_t>(random() % (64 * kPixelSteps)),
           static_cast<std::int32_t>(random() % (50 * kPixelSteps)),
           static_cast<std::int32_t>(random() % (40 * kLayerSteps))};
    }
    ASSERT_EQ(hits_of(t, grid), hits_by_definition(t, grid, 0, 64, 0, 50, 0)) << "triangle " << i;
  }
}

TEST(HeightSign, IsExactWhereDoublesAreNot) {
  const std::int64_t big = (std::int64_t{1} << 60) + 1;
  EXPECT_EQ(height_sign({big, big, 1}, {7, 9, 8}, 8), 0);
  EXPECT_EQ(height_sign({big, big, 1}, {7, 9, 9}, 8), 1);
  EXPECT_EQ(height_sign({big, big, 1}, {7, 9, 7}, 8), -1);
  EXPECT_EQ(height_sign({big, big + 1, 1}, {7, 9, 8}, 8), 1);
  EXPECT_EQ(height_sign({big + 1, big, 1}, {7, 9, 8}, 8), -1);
  const std::int64_t tall = std::int64_t{1} << 29;
  EXPECT_EQ(height_sign({big, big, 0}, {0, 2 * tall, 5}, tall), 0);
}

LatticeTriangle on_lattice(const TestMesh& mesh, const std::array<std::uint32_t, 3>& f, double steps) {
  LatticeTriangle t;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d& v = mesh.vertices[f[i]];
    t[i] = {static_cast<std::int32_t>(std::lround(v[0] * steps)), static_cast<std::int32_t>(std::lround(v[1] * steps)),
            static_cast<std::int32_t>(std::lround(v[2] * steps / 8))};
  }
  return t;
}

TEST(TriangleRays, EnterAClosedMeshAsOftenAsTheyLeaveItWhateverItsRounding) {
  const PrintGrid grid{.columns = 40, .rows = 40, .layers = 400};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 60; ++i) {
    TestMesh mesh = i % 3 == 0   ? ball_mesh({20, 20, 20}, 15, 2)
                    : i % 3 == 1 ? box_mesh({10, 10, 10}, {30, 30, 30})
                                 : tetrahedron_mesh({20, 5, 5}, {35, 30, 8}, {6, 30, 4}, {20, 20, 36});
    // A linear map with whole and half numbers keeps many corners on centres of pixels.
    Mat3d turn = Mat3d::Identity();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        turn(r, c) += i % 2 == 0 ? any(random) * 0.3 : (r != c ? std::floor(2 * any(random)) / 4 : 0);
    }
    for (Vec3d& v : mesh.vertices) v = Vec3d(20, 20, 20) + turn * (v - Vec3d(20, 20, 20)) * 0.7;
    if (i % 4 == 0) {
      for (Vec3d& v : mesh.vertices) v = (2 * v).array().round().matrix() / 2;
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sum;
    EdgeSum edges;
    for (const auto& f : mesh.faces) {
      const LatticeTriangle t = on_lattice(mesh, f, kPixelSteps);
      edges.add(t);
      for_each_hit(t, grid, [&](const RayHit& h) { sum[{h.row, h.column}] += h.entering ? 1 : -1; });
    }
    EXPECT_TRUE(edges.is_closed());
    EXPECT_GT(sum.size(), 50U);
    for (const auto& [ray, total] : sum)
      ASSERT_EQ(total, 0) << "mesh " << i << ", row " << ray.first << ", column " << ray.second;
  }
}

TEST(EdgeSum, SeesAHoleAFlippedFaceAndADoubledOne) {
  const TestMesh closed = ball_mesh({5, 5, 5}, 4, 2);
  const auto is_closed = [](const TestMesh& mesh) {
    EdgeSum edges;
    for (const auto& f : mesh.faces) edges.add(on_lattice(mesh, f, 1000));
    return edges.is_closed();
  };
  EXPECT_TRUE(is_closed(closed));
  EXPECT_TRUE(is_closed(shuffled(closed, 4)));
  TestMesh hole = closed;
  hole.faces.pop_back();
  EXPECT_FALSE(is_closed(hole));
  TestMesh flipped = closed;
  flip(flipped, 7, 8);
  EXPECT_FALSE(is_closed(flipped));
  TestMesh doubled = closed;
  doubled.faces.push_back(doubled.faces[3]);
  EXPECT_FALSE(is_closed(doubled));
}

TEST(HitList, SortsByTileRayAndLayer) {
  const PrintGrid grid{.columns = 3000, .rows = 2000, .layers = 65535};
  ArenaBlock arena(4 * kMiB);
  HitList list = *HitList::create(grid, *arena);
  EXPECT_EQ(arena->available(), 0U);
  std::mt19937 random(5);
  std::vector<PackedHit> expected;
  for (int i = 0; i < 100'001; ++i) {
    const RayHit hit{static_cast<std::uint32_t>(random() % 3000), static_cast<std::uint32_t>(random() % 2000),
                     CrossingHeight(static_cast<std::uint32_t>(random() % 65536), random() % 256), random() % 2 == 0};
    ASSERT_TRUE(list.add(hit));
    const HitPacking& packing = list.packing();
    const PackedHit packed = packing.packed(hit);
    EXPECT_EQ(packing.tile(packed), hit.row / 8 * 375 + hit.column / 8);
    EXPECT_EQ(packing.ray(packed), hit.row % 8 * 8 + hit.column % 8);
    EXPECT_EQ(packing.layer(packed), hit.height.layer());
    EXPECT_EQ(packing.winding(packed), hit.entering ? 1 : -1);
    EXPECT_NEAR(packing.height(packed).part(), hit.height.part(), 8) << "five bits are left";
    expected.push_back(packed);
  }
  ASSERT_TRUE(list.close(*arena));
  EXPECT_LE(arena->top_used(), 100'001 * sizeof(PackedHit) + Arena::kAlignment);
  std::sort(expected.begin(), expected.end());
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), list.all().begin(), list.all().end()));
  std::size_t in_tiles = 0;
  for (std::uint32_t tile = 0; tile < 375 * 250; ++tile) {
    for (const PackedHit& hit : list.of_tile(tile)) EXPECT_EQ(list.packing().tile(hit), tile);
    in_tiles += list.of_tile(tile).size();
  }
  EXPECT_EQ(in_tiles, expected.size());
}

TEST(HitList, SaysWhenItIsFull) {
  const PrintGrid grid{.columns = 8, .rows = 8, .layers = 10};
  ArenaBlock arena(256);
  HitList list = *HitList::create(grid, *arena);
  for (std::size_t i = 0; i < list.capacity(); ++i) EXPECT_TRUE(list.add({}));
  EXPECT_FALSE(list.add({}));
}

}  // namespace
}  // namespace plumbline
