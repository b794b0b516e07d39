#include "slicer/layers/layer_features.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/slicer/support/voxels.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A block of 50 x 30 pixels and 20 layers. Each test cuts other parts out of it or adds others.
bool block(std::uint32_t c, std::uint32_t r, std::uint32_t k) { return Block{10, 60, 5, 35, 0, 20}.has(c, r, k); }

/// A block as high as the grid.
bool high_block(std::uint32_t c, std::uint32_t r, std::uint32_t k) {
  return Block{1, kColumns - 1, 1, kRows - 1, 0, kLayers}.has(c, r, k);
}

constexpr FeatureLimits kLimits{
    .pixels = 40, .voxels = 200, .narrow_pixels = 40, .narrow_layers = 20, .flat_layers = 1, .loose_voxels = 200};

TEST(LayerFeatures, FillsADentThatOpensToTheOutsideInTheNextLayers) {
  // The block has a groove in its top, open at one side. The bottom of its inner end dips by three layers.
  const Inside wanted = [](auto c, auto r, auto k) {
    return block(c, r, k) && !Block{20, 60, 15, 20, 15, 20}.has(c, r, k);
  };
  Voxels voxels([&](auto c, auto r, auto k) { return wanted(c, r, k) && !Block{20, 24, 15, 20, 12, 15}.has(c, r, k); });
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_EQ(counts->holes, 1U);
  EXPECT_EQ(counts->islands, 0U);
  EXPECT_EQ(counts->voxels, 4U * 5 * 3);
  EXPECT_TRUE(voxels.equals(wanted));
}

TEST(LayerFeatures, RemovesABumpThatBeginsBelowTheObjectItMeets) {
  // A ledge of the block begins at layer 10. A bump of four layers hangs below it.
  const Inside wanted = [](auto c, auto r, auto k) {
    return Block{10, 40, 5, 35, 0, 20}.has(c, r, k) || Block{40, 60, 5, 35, 10, 20}.has(c, r, k);
  };
  Voxels voxels([&](auto c, auto r, auto k) { return wanted(c, r, k) || Block{50, 55, 10, 15, 6, 10}.has(c, r, k); });
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_EQ(counts->islands, 1U);
  EXPECT_TRUE(voxels.equals(wanted));
}

TEST(LayerFeatures, CountsThePixelsOfMasksThatItLeavesAlone) {
  Voxels voxels([](auto c, auto r, auto k) { return k >= 3 && k < 17 && block(c, r, k) && (c < 40 || k > 9); });
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  ASSERT_TRUE(counts->totals.has_value());
  EXPECT_EQ(counts->totals->empty.below, 3U);
  EXPECT_EQ(counts->totals->empty.above, kLayers - 17);
  EXPECT_EQ(counts->totals->first_pixels, 30U * 30);
  EXPECT_EQ(counts->totals->pixels, 7U * 30 * 30 + 7U * 50 * 30);
}

TEST(LayerFeatures, CountsNoPixelsOfMasksThatItChanges) {
  Voxels voxels([](auto c, auto r, auto k) { return block(c, r, k) && !Block{20, 24, 15, 19, 5, 9}.has(c, r, k); });
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_EQ(counts->holes, 1U);
  EXPECT_FALSE(counts->totals.has_value());
}

TEST(LayerFeatures, FillsACavityAndDropsALooseIsland) {
  Voxels voxels([](auto c, auto r, auto k) {
    return (block(c, r, k) && !Block{20, 24, 15, 19, 5, 9}.has(c, r, k)) || Block{63, 67, 8, 12, 4, 8}.has(c, r, k);
  });
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_EQ(counts->holes, 1U);
  EXPECT_EQ(counts->islands, 1U);
  EXPECT_TRUE(voxels.equals(block));
}

TEST(LayerFeatures, KeepsTheTipOfAGrowingPartAndTheBottomOfAPit) {
  const auto stays = [](const Inside& solid) {
    Voxels voxels(solid);
    const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
    ASSERT_TRUE(counts.has_value());
    EXPECT_EQ(counts->holes + counts->islands, 0U);
    EXPECT_TRUE(voxels.equals(solid));
  };
  // A chin: an island that gets wider in each layer until it meets the block's ledge.
  stays([](auto c, auto r, auto k) {
    const std::uint32_t wide = k < 5 ? 0 : k - 3;
    return Block{5, 30, 5, 35, 0, 20}.has(c, r, k) || Block{30, 60, 5, 35, 16, 20}.has(c, r, k) ||
           Block{50 - std::min(wide, 9U), 50 + std::min(wide, 9U), 20 - wide, 20 + wide, 5, 16}.has(c, r, k);
  });
  // A funnel.
  stays([](auto c, auto r, auto k) {
    const std::uint32_t wide = k < 5 ? 0 : std::min(k - 4, 12U);
    return block(c, r, k) && !Block{35 - wide, 35 + wide, 20 - wide, 20 + wide, 5, 20}.has(c, r, k);
  });
}

TEST(LayerFeatures, KeepsNeedlesAndShaftsOfManyVoxelsOrLayers) {
  const Inside solid = [](auto c, auto r, auto k) {
    return (block(c, r, k) && !Block{20, 24, 15, 19, 3, 20}.has(c, r, k)) || Block{40, 44, 15, 19, 20, 30}.has(c, r, k);
  };
  FeatureLimits few_voxels = kLimits;
  few_voxels.voxels = 150;  // the needle has 160 voxels, the shaft 272
  FeatureLimits few_layers = kLimits;
  few_layers.voxels = 300;
  few_layers.narrow_layers = 9;  // they have 10 and 17
  for (const FeatureLimits& limits : {few_voxels, few_layers}) {
    Voxels voxels(solid);
    const auto counts = drop_small_features(voxels.rrep, limits, *voxels.block);
    ASSERT_TRUE(counts.has_value());
    EXPECT_EQ(counts->holes + counts->islands, 0U);
    EXPECT_TRUE(voxels.equals(solid));
  }
}

// Letters on stalks once lost the stalks and floated.
TEST(LayerFeatures, KeepsStalksThatCarryALargerPart) {
  const Inside stalks = [](auto c, auto r, auto k) {
    return Block{22, 26, 15, 19, 20, 24}.has(c, r, k) || Block{44, 48, 15, 19, 20, 24}.has(c, r, k);
  };
  const Inside on_stalks = [](auto c, auto r, auto k) { return Block{20, 50, 10, 25, 24, 28}.has(c, r, k); };
  const Inside post = [](auto c, auto r, auto k) { return Block{30, 40, 10, 25, 20, 24}.has(c, r, k); };
  const auto islands_removed = [&](const Inside& rest) {
    Voxels voxels([&](auto c, auto r, auto k) { return rest(c, r, k) || stalks(c, r, k); });
    return value_of(drop_small_features(voxels.rrep, kLimits, *voxels.block)).islands;
  };
  EXPECT_EQ(islands_removed([&](auto c, auto r, auto k) { return block(c, r, k) || on_stalks(c, r, k); }), 0U);
  // With a post between the stalks, the part stands without them.
  EXPECT_EQ(
      islands_removed([&](auto c, auto r, auto k) { return block(c, r, k) || on_stalks(c, r, k) || post(c, r, k); }),
      2U);
  // The part hangs from the stalks.
  EXPECT_EQ(islands_removed([&](auto c, auto r, auto k) {
              return Block{30, 40, 12, 22, 14, 20}.has(c, r, k) || Block{20, 50, 10, 25, 18, 20}.has(c, r, k) ||
                     Block{5, 65, 2, 38, 24, 30}.has(c, r, k);
            }),
            0U);
}

// A needle that the masks' opening had cut off once stayed because it was higher than a narrow feature may be.
TEST(LayerFeatures, RemovesLooseFeaturesUnlessNothingElseIsThere) {
  const auto needle = [](auto c, auto r, auto k) { return Block{63, 67, 8, 12, 4, 16}.has(c, r, k); };
  const auto spur = [](auto c, auto r, auto k) { return Block{60, 63, 10, 11, 9, 10}.has(c, r, k); };
  FeatureLimits limits = kLimits;
  limits.narrow_layers = 5;
  Voxels attached([&](auto c, auto r, auto k) { return block(c, r, k) || spur(c, r, k) || needle(c, r, k); });
  ASSERT_TRUE(drop_small_features(attached.rrep, limits, *attached.block).has_value());
  EXPECT_TRUE(attached.equals([&](auto c, auto r, auto k) { return block(c, r, k) || spur(c, r, k); }));
  Voxels alone(needle);
  ASSERT_TRUE(drop_small_features(alone.rrep, limits, *alone.block).has_value());
  EXPECT_TRUE(alone.equals(needle));
}

TEST(LayerFeatures, KeepsBlindHolesThatOpenBelowTheFirstLayerOrAboveTheLastOne) {
  const auto pierced = [](auto c, auto r, auto k) {
    return high_block(c, r, k) && !Block{20, 24, 15, 19, 0, 10}.has(c, r, k) &&
           !Block{40, 44, 15, 19, kLayers - 8, kLayers}.has(c, r, k);
  };
  FeatureLimits limits = kLimits;
  limits.narrow_layers = 5;
  Voxels open(pierced);
  ASSERT_TRUE(drop_small_features(open.rrep, limits, *open.block).has_value());
  EXPECT_TRUE(open.equals(pierced));
}

TEST(LayerFeatures, KeepsDotsThatAreWideAndHighAndRemovesFlatOrNarrowOnes) {
  // Two dots each: a single one would be all that continues the layer below, so it would stay.
  const auto dots = [](std::uint32_t side, std::uint32_t layers) {
    return [=](auto c, auto r, auto k) {
      return Block{15, 15 + side, 10, 10 + side, 20, 20 + layers}.has(c, r, k) ||
             Block{40, 40 + side, 20, 20 + side, 20, 20 + layers}.has(c, r, k);
    };
  };
  const FeatureLimits limits{
      .pixels = 100, .voxels = 1000, .narrow_pixels = 20, .narrow_layers = 6, .flat_layers = 2, .loose_voxels = 0};
  const auto islands_removed = [&](std::uint32_t side, std::uint32_t layers) {
    Voxels voxels([dot = dots(side, layers)](auto c, auto r, auto k) { return block(c, r, k) || dot(c, r, k); });
    return value_of(drop_small_features(voxels.rrep, limits, *voxels.block)).islands;
  };
  EXPECT_EQ(islands_removed(8, 6), 0U);
  EXPECT_EQ(islands_removed(8, 3), 0U);
  EXPECT_EQ(islands_removed(8, 2), 2U);
  EXPECT_EQ(islands_removed(5, 6), 0U);
  EXPECT_EQ(islands_removed(4, 6), 2U);
}

/// high_block() full of cubic cavities of `side` voxels, one each `pitch`.
Inside bubbly(std::uint32_t side, std::uint32_t pitch) {
  return [=](auto c, auto r, auto k) {
    // A cavity takes the last `side` voxels of each whole pitch.
    const auto hollow = [&](std::uint32_t at, std::uint32_t from, std::uint32_t to) {
      return at >= from && (at - from) % pitch >= pitch - side && at - (at - from) % pitch + pitch < to;
    };
    return high_block(c, r, k) && !(hollow(c, 2, kColumns) && hollow(r, 2, kRows) && hollow(k, 0, kLayers));
  };
}

TEST(LayerFeatures, FillsMoreVoxelsThanFitOneBatchOfToggles) {
  Voxels voxels(bubbly(5, 8));
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_EQ(counts->holes, 8U * 4 * 3);
  EXPECT_EQ(counts->voxels, 8U * 4 * 3 * 125);
  EXPECT_TRUE(voxels.equals(high_block));
}

TEST(LayerFeatures, LeavesTheLayersAloneAboveWhereItsRoomEnds) {
  // Each level has 13 x 7 cavities of three layers, one region a layer. The third level exceeds the room.
  const Inside all = bubbly(3, 5);
  Voxels voxels(all);
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_TRUE(counts->counted);
  EXPECT_EQ(counts->holes, 13U * 7 * 2);
  EXPECT_TRUE(voxels.equals([&](auto c, auto r, auto k) { return k < 10 ? high_block(c, r, k) : all(c, r, k); }));
}

TEST(LayerFeatures, TakesNoMoreOfTheArenaThanStated) {
  for (const Inside& inside : {Inside(block), bubbly(5, 8), bubbly(3, 5)}) {
    Voxels voxels(inside);
    Arena& arena = *voxels.block;
    const std::size_t before = arena.used();
    arena.reset_peak();
    ASSERT_TRUE(drop_small_features(voxels.rrep, kLimits, arena).has_value());
    EXPECT_LE(arena.peak() - before, layer_features_bytes(voxels.rrep.grid));
    EXPECT_GT(arena.peak() - before, layer_features_bytes(voxels.rrep.grid) / 2);
    EXPECT_LE(arena.used(), before);
  }
}

TEST(LayerFeatures, ReleasesTheArenaAndChangesNothingWithoutRoom) {
  const Inside dented = [](auto c, auto r, auto k) {
    return block(c, r, k) && !Block{20, 24, 15, 19, 5, 9}.has(c, r, k);
  };
  Voxels voxels(dented);
  Arena& arena = *voxels.block;
  const std::size_t top = arena.top_used();
  ASSERT_TRUE(drop_small_features(voxels.rrep, kLimits, arena).has_value());
  EXPECT_EQ(arena.top_used(), top);
  EXPECT_LE(arena.bottom_used(),
            Arena::rounded(voxels.rrep.first.size_bytes()) + Arena::rounded(voxels.rrep.packed.size_bytes()));

  Voxels crowded(dented);
  ASSERT_TRUE(crowded.block->take_top<std::byte>(crowded.block->available() - 4096, "test").has_value());
  const auto counts = drop_small_features(crowded.rrep, kLimits, *crowded.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_FALSE(counts->counted);
  EXPECT_TRUE(crowded.equals(dented));
}

}  // namespace
}  // namespace plumbline
