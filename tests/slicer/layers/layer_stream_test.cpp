#include "slicer/layers/layer_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/pixels.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// Random crossings by layer, in clumps: neighbours change together, as in a real object.
struct RandomRRep {
  std::vector<std::uint32_t> first{0};
  std::vector<std::uint32_t> packed;
  RRep rrep;

  RandomRRep(std::uint32_t columns, std::uint32_t rows, std::uint32_t layers, Random& random) {
    rrep.grid.columns = columns;
    rrep.grid.rows = rows;
    rrep.grid.layers = layers;
    const CrossingPacking packing(rrep.grid);
    for (std::uint32_t k = 0; k < layers; ++k) {
      std::set<std::uint32_t> toggled;
      for (std::uint32_t clump = random.below(4); clump > 0; --clump) {
        const std::uint32_t c = random.below(columns);
        const std::uint32_t r = random.below(rows);
        const std::uint32_t wide = 1 + random.below(30);
        const std::uint32_t high = 1 + random.below(8);
        for (std::uint32_t y = r; y < std::min(rows, r + high); ++y) {
          for (std::uint32_t x = c; x < std::min(columns, c + wide); ++x) {
            if (random.below(10) != 0) toggled.insert(y * columns + x);
          }
        }
      }
      for (const std::uint32_t pixel : toggled) packed.push_back(packing.packed(pixel, random.below(256)));
      first.push_back(static_cast<std::uint32_t>(packed.size()));
    }
    rrep.first = first;
    rrep.packed = packed;
  }

  Pixels mask_by_definition(std::uint32_t layer) const {
    Pixels section(rrep.grid.columns, rrep.grid.rows);
    for (std::uint32_t i = 0; i < first[layer + 1]; ++i) section.toggle(CrossingPacking(rrep.grid).pixel(packed[i]));
    return opened_and_closed_by_definition(section);
  }
};

class LayerStreamOfSize : public ::testing::TestWithParam<std::tuple<std::uint32_t, std::uint32_t>> {};
INSTANTIATE_TEST_SUITE_P(Sizes, LayerStreamOfSize,
                         ::testing::Combine(::testing::Values(1, 2, 63, 64, 65, 129, 4097),
                                            ::testing::Values(1, 3, 20)),
                         [](const auto& size) {
                           return std::to_string(std::get<0>(size.param)) + "x" +
                                  std::to_string(std::get<1>(size.param));
                         });

TEST_P(LayerStreamOfSize, StreamsTheMasksThatTogglingAllCrossingsGives) {
  const auto [columns, rows] = GetParam();
  Random random(columns * 100 + rows);
  const RandomRRep object(columns, rows, 25, random);
  ArenaBlock arena(kMiB);
  LayerStream stream = value_of(LayerStream::create(object.rrep, *arena));
  for (std::uint32_t k = 0; k < 25; ++k) {
    ASSERT_EQ(Pixels(stream.mask(k)), object.mask_by_definition(k)) << "layer " << k;
  }
}

TEST_P(LayerStreamOfSize, GivesAnyLayerInAnyOrder) {
  const auto [columns, rows] = GetParam();
  Random random(columns * 200 + rows);
  const RandomRRep object(columns, rows, 25, random);
  ArenaBlock arena(kMiB);
  LayerStream stream = value_of(LayerStream::create(object.rrep, *arena));
  for (int i = 0; i < 25; ++i) {
    const std::uint32_t k = random.below(25);
    ASSERT_EQ(Pixels(stream.mask(k)), object.mask_by_definition(k)) << "layer " << k;
    ASSERT_EQ(Pixels(stream.mask(k)), object.mask_by_definition(k)) << "layer " << k << " again";
  }
}

TEST(LayerStream, GivesTheDocumentedExample) {
  // A block of 4 x 3 rays, solid from layer 1 to layer 3: wide enough that opening does not change it.
  std::vector<std::uint32_t> block;
  for (std::uint32_t r = 1; r < 4; ++r) {
    for (std::uint32_t c = 2; c < 6; ++c)
      block.push_back(CrossingPacking({.columns = 10, .rows = 5}).packed(r * 10 + c));
  }
  std::vector<std::uint32_t> packed = block;
  packed.insert(packed.end(), block.begin(), block.end());
  const std::vector<std::uint32_t> first = {0, 0, 12, 12, 24, 24};
  RRep rrep;
  rrep.grid.columns = 10;
  rrep.grid.rows = 5;
  rrep.grid.layers = 5;
  rrep.first = first;
  rrep.packed = packed;
  ArenaBlock arena(kMiB);
  LayerStream stream = value_of(LayerStream::create(rrep, *arena));
  EXPECT_EQ(stream.mask(0).count(), 0U);
  EXPECT_EQ(stream.mask(1).count(), 12U);
  EXPECT_EQ(stream.mask(2).count(), 12U);
  EXPECT_EQ(stream.mask(3).count(), 0U);
  EXPECT_EQ(stream.mask(4).count(), 0U);
}

TEST(LayerStream, TakesTheBytesItStates) {
  Random random(3);
  const RandomRRep object(777, 333, 2, random);
  ArenaBlock arena(kMiB);
  ASSERT_TRUE(LayerStream::create(object.rrep, *arena).has_value());
  EXPECT_EQ(arena->bottom_used(), LayerStream::bytes_needed(object.rrep.grid));
  EXPECT_EQ(arena->top_used(), 0U);
}

TEST(LayerStream, IsRefusedIfItsImagesDoNotFit) {
  Random random(4);
  const RandomRRep object(1024, 1024, 2, random);
  ArenaBlock arena(kMiB / 8);
  const auto stream = LayerStream::create(object.rrep, *arena);
  ASSERT_FALSE(stream.has_value());
  EXPECT_EQ(stream.error().code(), ErrorCode::kOutOfMemory);
}

}  // namespace
}  // namespace plumbline
