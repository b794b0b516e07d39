#include "slicer/layers/rrep_edit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tests/slicer/support/surfaces.hpp"
#include "tests/slicer/support/voxels.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(RRepEdit, TogglesLikeASetOfVoxels) {
  Random random(9);
  for (int round = 0; round < 20; ++round) {
    std::vector<bool> on(std::size_t{kLayers} * kRows * kColumns);
    for (auto&& voxel : on) voxel = random.below(4) == 0;
    const Inside solid = [&](auto c, auto r, auto k) { return on[(std::size_t{k} * kRows + r) * kColumns + c]; };
    Voxels voxels(solid);
    std::vector<RRepToggle> toggles;
    for (std::uint32_t n = random.below(500); n > 0; --n) {
      const std::uint32_t k = random.below(kLayers + 1);
      const std::uint32_t p = random.below(kRows * kColumns);
      toggles.push_back({k, p});
      if (random.below(8) == 0) toggles.push_back({k, p});  // a pair changes nothing
    }
    for (const RRepToggle& t : toggles) {
      for (std::uint32_t k = t.layer; k < kLayers; ++k) {
        auto bit = on[std::size_t{k} * kRows * kColumns + t.pixel];
        bit = !bit;
      }
    }
    ASSERT_TRUE(toggle_crossings(voxels.rrep, toggles, *voxels.block).has_value());
    EXPECT_TRUE(voxels.equals(solid));
  }
}

void expect_trimmed(Voxels& voxels, std::uint32_t below, std::uint32_t above) {
  const std::uint32_t layers = voxels.rrep.grid.layers;
  const EmptyLayers empty = value_of(trim_empty_layers(voxels.rrep, *voxels.block));
  EXPECT_EQ(empty.below, below);
  EXPECT_EQ(empty.above, above);
  EXPECT_EQ(voxels.rrep.grid.layers, layers - below - above);
  EXPECT_EQ(voxels.rrep.first.size(), voxels.rrep.grid.layers + 1U);
  EXPECT_EQ(voxels.rrep.first.back(), voxels.rrep.crossings());
}

TEST(RRepEdit, TrimsEmptyLayersBelowAndAboveTheObject) {
  const Inside wanted = [](auto c, auto r, auto k) { return Block{10, 60, 5, 35, 0, 12}.has(c, r, k); };
  Voxels voxels([&](auto c, auto r, auto k) { return k >= 7 && wanted(c, r, k - 7); });
  expect_trimmed(voxels, 7, kLayers - 19);
  EXPECT_TRUE(voxels.equals(wanted));
  expect_trimmed(voxels, 0, 0);
  EXPECT_TRUE(voxels.equals(wanted));
}

// Prints once began and ended with empty masks: those layers held only the one-pixel tip of an outlier, which opening
// removes.
TEST(RRepEdit, TrimsLayersThatOpeningEmpties) {
  const auto spur = [](auto c, auto r, auto k) { return c == 20 && r == 20 && k >= 2; };
  const auto block_on_it = [](auto c, auto r, auto k) { return Block{10, 60, 5, 35, 0, 12}.has(c, r, k); };
  const auto passing = [](auto c, auto r, auto k) { return c == 30 && r == 9 && k >= 1 && k < 5; };
  Voxels voxels([&](auto c, auto r, auto k) {
    return spur(c, r, k) || passing(c, r, k) || (k >= 7 && block_on_it(c, r, k - 7));
  });
  expect_trimmed(voxels, 7, kLayers - 19);
  EXPECT_TRUE(voxels.equals([&](auto c, auto r, auto k) { return block_on_it(c, r, k) || (c == 20 && r == 20); }));
}

TEST(RRepEdit, CutsLayersInPlace) {
  Random random(17);
  for (const EmptyLayers cut : {EmptyLayers{0, 0}, EmptyLayers{4, 0}, EmptyLayers{0, 5}, EmptyLayers{9, 3}}) {
    std::vector<bool> on(std::size_t{kLayers} * kRows * kColumns);
    for (auto&& voxel : on) voxel = random.below(3) == 0;
    Voxels voxels([&](auto c, auto r, auto k) { return on[(std::size_t{k} * kRows + r) * kColumns + c]; });
    const std::size_t used = voxels.block->used();
    for (int again = 0; again < 2; ++again) cut_layers(voxels.rrep, cut);
    EXPECT_EQ(voxels.block->used(), used);
    EXPECT_EQ(voxels.rrep.grid.layers, kLayers - 2 * (cut.below + cut.above));
    EXPECT_EQ(voxels.rrep.first.front(), 0U);
    EXPECT_EQ(voxels.rrep.first.back(), voxels.rrep.crossings());
    EXPECT_TRUE(voxels.equals(
        [&](auto c, auto r, auto k) { return on[(std::size_t{k + 2 * cut.below} * kRows + r) * kColumns + c]; }));
  }
}

TEST(RRepEdit, FindsTheLastLayerBelowManyEmptyOnes) {
  const Inside low = [](auto c, auto r, auto k) { return Block{10, 60, 5, 35, 0, 2}.has(c, r, k); };
  ASSERT_GT(kLayers, 20U) << "more than are looked at first";
  Voxels voxels(low);
  expect_trimmed(voxels, 0, kLayers - 2);
  EXPECT_TRUE(voxels.equals(low));
}

TEST(RRepEdit, RefusesAnObjectOfWhichNoLayerPrints) {
  const Inside needle = [](auto c, auto r, auto k) { return c == 20 && r == 20 && k >= 2; };
  Voxels voxels(needle);
  for (const auto known : {std::optional<EmptyLayers>(), std::optional(EmptyLayers{.below = kLayers})}) {
    const auto trimmed = trim_empty_layers(voxels.rrep, *voxels.block, known);
    ASSERT_FALSE(trimmed.has_value());
    EXPECT_EQ(trimmed.error().code(), ErrorCode::kNoSurface);
    EXPECT_TRUE(voxels.equals(needle));
  }
}

TEST(RRepEdit, RaisesTheObject) {
  Solid solid(cubic_grid(16, 6), [](std::uint32_t c, std::uint32_t r, std::uint32_t k) { return c + r > 3 * k; });
  const auto before = solid.masks();
  ArenaBlock arena(kMiB);
  ASSERT_TRUE(raise_object(solid.rrep, 4, *arena));
  const auto after = solid.masks();
  ASSERT_EQ(after.size(), before.size() + 4);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(after[k].count(), 0U);
  for (std::size_t k = 0; k < before.size(); ++k) EXPECT_EQ(after[k + 4], before[k]);
  ArenaBlock full(64);
  EXPECT_FALSE(raise_object(solid.rrep, 100, *full));
  EXPECT_EQ(solid.rrep.grid.layers, 10U);
}

}  // namespace
}  // namespace plumbline
