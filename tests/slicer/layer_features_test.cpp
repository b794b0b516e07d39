#include "slicer/layer_features.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "slicer/layer_regions.hpp"
#include "slicer/rrep_edit.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/solid.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr std::uint32_t kColumns = 70;
constexpr std::uint32_t kRows = 40;
constexpr std::uint32_t kLayers = 30;

PrintGrid grid_of(std::uint32_t layers) { return {.columns = kColumns, .rows = kRows, .layers = layers}; }

/// The R-Rep of a solid at the bottom of an arena, as the builder leaves it.
struct Voxels {
  ArenaBlock block{8 * kMiB};
  RRep rrep;

  explicit Voxels(const Inside& inside) : rrep{grid_of(kLayers), {}, {}} {
    const Solid solid(rrep.grid, inside);
    const auto first = value_of(block->take_bottom<std::uint32_t>(solid.first.size(), "test"));
    const auto pixel = value_of(block->take_bottom<std::uint32_t>(solid.pixel.size(), "test"));
    std::copy(solid.first.begin(), solid.first.end(), first.begin());
    std::copy(solid.pixel.begin(), solid.pixel.end(), pixel.begin());
    rrep.first = first;
    rrep.pixel = pixel;
  }
  bool equals(const Inside& inside) const {
    const Solid wanted(rrep.grid, inside);
    return std::equal(wanted.first.begin(), wanted.first.end(), rrep.first.begin(), rrep.first.end()) &&
           std::equal(wanted.pixel.begin(), wanted.pixel.end(), rrep.pixel.begin(), rrep.pixel.end());
  }
};

/// A block of 50 x 30 pixels and 20 layers; what is cut out of it and put on it differs from test to test.
bool block(std::uint32_t c, std::uint32_t r, std::uint32_t k) { return Block{10, 60, 5, 35, 0, 20}.has(c, r, k); }

/// A block as high as the grid.
bool high_block(std::uint32_t c, std::uint32_t r, std::uint32_t k) {
  return Block{1, kColumns - 1, 1, kRows - 1, 0, kLayers}.has(c, r, k);
}

constexpr FeatureLimits kLimits{
    .pixels = 40, .voxels = 200, .narrow_pixels = 40, .narrow_layers = 20, .flat_layers = 1, .loose_voxels = 200};

TEST(LayerFeatures, FillsADentThatOpensToTheOutsideInTheNextLayers) {
  // The block has a groove at its top, from a side inwards; under its inner end the surface dips for three layers.
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

TEST(LayerFeatures, TakesOutABumpThatBeginsBeforeItMeetsTheObject) {
  // A ledge of the block begins at layer 10; beneath its end hang four layers of bump.
  const Inside wanted = [](auto c, auto r, auto k) {
    return Block{10, 40, 5, 35, 0, 20}.has(c, r, k) || Block{40, 60, 5, 35, 10, 20}.has(c, r, k);
  };
  Voxels voxels([&](auto c, auto r, auto k) { return wanted(c, r, k) || Block{50, 55, 10, 15, 6, 10}.has(c, r, k); });
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_EQ(counts->islands, 1U);
  EXPECT_TRUE(voxels.equals(wanted));
}

TEST(LayerFeatures, FillsABubbleAndDropsACrumb) {
  Voxels voxels([](auto c, auto r, auto k) {
    return (block(c, r, k) && !Block{20, 24, 15, 19, 5, 9}.has(c, r, k)) || Block{63, 67, 8, 12, 4, 8}.has(c, r, k);
  });
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_EQ(counts->holes, 1U);
  EXPECT_EQ(counts->islands, 1U);
  EXPECT_TRUE(voxels.equals(block));
}

TEST(LayerFeatures, KeepsTheTipOfWhatGrowsAndTheBottomOfAPitThatWidens) {
  const auto stays = [](const Inside& solid) {
    Voxels voxels(solid);
    const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
    ASSERT_TRUE(counts.has_value());
    EXPECT_EQ(counts->holes + counts->islands, 0U);
    EXPECT_TRUE(voxels.equals(solid));
  };
  // A chin: an island that is wider in each layer before it meets the block's ledge.
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

// Letters lost what they stood on, and floated.
TEST(LayerFeatures, KeepsTheStalksThatSomethingStandsOn) {
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
  // With a post between them it stands without them.
  EXPECT_EQ(
      islands_removed([&](auto c, auto r, auto k) { return block(c, r, k) || on_stalks(c, r, k) || post(c, r, k); }),
      2U);
  // It hangs from them.
  EXPECT_EQ(islands_removed([&](auto c, auto r, auto k) {
              return Block{30, 40, 12, 22, 14, 20}.has(c, r, k) || Block{20, 50, 10, 25, 18, 20}.has(c, r, k) ||
                     Block{5, 65, 2, 38, 24, 30}.has(c, r, k);
            }),
            0U);
}

// The opening of the masks had cut it off, and it was high enough to stay.
TEST(LayerFeatures, TakesOutWhatTouchesNothingUnlessItIsAllThereIs) {
  const auto needle = [](auto c, auto r, auto k) { return Block{63, 67, 8, 12, 4, 16}.has(c, r, k); };
  const auto spur = [](auto c, auto r, auto k) { return Block{60, 63, 10, 11, 9, 10}.has(c, r, k); };
  FeatureLimits limits = kLimits;
  limits.narrow_layers = 5;
  Voxels attached([&](auto c, auto r, auto k) { return block(c, r, k) || spur(c, r, k) || needle(c, r, k); });
  ASSERT_TRUE(drop_small_features(attached.rrep, limits, *attached.block).has_value());
  EXPECT_TRUE(attached.equals([&](auto c, auto r, auto k) { return block(c, r, k) || spur(c, r, k); }));
  const auto pierced = [](auto c, auto r, auto k) {
    return high_block(c, r, k) && !Block{20, 24, 15, 19, 0, 10}.has(c, r, k) &&
           !Block{40, 44, 15, 19, kLayers - 8, kLayers}.has(c, r, k);
  };
  Voxels open(pierced);
  ASSERT_TRUE(drop_small_features(open.rrep, limits, *open.block).has_value());
  EXPECT_TRUE(open.equals(pierced)) << "a blind hole opens below the first layer, or above the last one";
  Voxels alone(needle);
  ASSERT_TRUE(drop_small_features(alone.rrep, limits, *alone.block).has_value());
  EXPECT_TRUE(alone.equals(needle));
}

TEST(LayerFeatures, KeepsDotsThatAreWideAndHighAndNoneThatAreFlatOrNarrow) {
  // Two of each kind: one alone would be all that the layer below goes on as.
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

/// The same, full of cubic bubbles at this pitch.
Inside bubbly(std::uint32_t side, std::uint32_t pitch) {
  return [=](auto c, auto r, auto k) {
    // The last `side` of each pitch, in as many pitches as there are.
    const auto hollow = [&](std::uint32_t at, std::uint32_t from, std::uint32_t to) {
      return at >= from && (at - from) % pitch >= pitch - side && at - (at - from) % pitch + pitch < to;
    };
    return high_block(c, r, k) && !(hollow(c, 2, kColumns) && hollow(r, 2, kRows) && hollow(k, 0, kLayers));
  };
}

TEST(LayerFeatures, FillsMoreVoxelsThanItTogglesAtOnce) {
  Voxels voxels(bubbly(5, 8));
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_EQ(counts->holes, 8U * 4 * 3);
  EXPECT_EQ(counts->voxels, 8U * 4 * 3 * 125);
  EXPECT_TRUE(voxels.equals(high_block));
}

TEST(LayerFeatures, LeavesTheLayersAsTheyAreFromWhereItHasNoRoomForMore) {
  // 13 x 7 bubbles, each a region in three layers: more than there is room for when they come the third time.
  const Inside all = bubbly(3, 5);
  Voxels voxels(all);
  const auto counts = drop_small_features(voxels.rrep, kLimits, *voxels.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_TRUE(counts->counted);
  EXPECT_EQ(counts->holes, 13U * 7 * 2);
  EXPECT_TRUE(voxels.equals([&](auto c, auto r, auto k) { return k < 10 ? high_block(c, r, k) : all(c, r, k); }));
}

TEST(LayerFeatures, TakeNoMoreOfTheArenaThanTheySay) {
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

TEST(LayerFeatures, GivesTheArenaBackAndLeavesAloneWhereItHasNoRoom) {
  const Inside dented = [](auto c, auto r, auto k) {
    return block(c, r, k) && !Block{20, 24, 15, 19, 5, 9}.has(c, r, k);
  };
  Voxels voxels(dented);
  Arena& arena = *voxels.block;
  const std::size_t top = arena.top_used();
  ASSERT_TRUE(drop_small_features(voxels.rrep, kLimits, arena).has_value());
  EXPECT_EQ(arena.top_used(), top);
  EXPECT_LE(arena.bottom_used(),
            Arena::rounded(voxels.rrep.first.size_bytes()) + Arena::rounded(voxels.rrep.pixel.size_bytes()));

  Voxels crowded(dented);
  ASSERT_TRUE(crowded.block->take_top<std::byte>(crowded.block->available() - 4096, "test").has_value());
  const auto counts = drop_small_features(crowded.rrep, kLimits, *crowded.block);
  ASSERT_TRUE(counts.has_value());
  EXPECT_FALSE(counts->counted);
  EXPECT_TRUE(crowded.equals(dented));
}

TEST(LayerRegions, AreThoseOfAFloodFill) {
  Random random(5);
  ArenaBlock memory(std::size_t{4} << 20);
  auto regions = LayerRegions::create(kColumns, kRows, *memory);
  ASSERT_TRUE(regions.has_value());
  std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
  for (const std::uint32_t percent : {10U, 40U, 50U, 60U, 90U}) {
    const BitImage image(words, kColumns, kRows);
    image.clear();
    for (std::uint32_t r = 0; r < kRows; ++r) {
      for (std::uint32_t c = 0; c < kColumns; ++c) {
        if (random.below(100) < percent) image.set(c, r);
      }
    }
    ASSERT_TRUE(regions->label(image));
    // Region of each pixel, then the same partition by flood fill: the pairs of names must be one to one.
    std::vector<std::uint32_t> region(std::size_t{kColumns} * kRows);
    for (std::uint32_t r = 0; r < kRows; ++r) {
      for (std::uint32_t i = regions->row_begin(r); i < regions->row_begin(r + 1); ++i) {
        const LayerRegions::Run run = regions->run(i);
        for (std::uint32_t c = run.first; run.first <= run.last && c <= run.last; ++c) {
          EXPECT_EQ(regions->white(r, i), image.at(c, r));
          region[r * kColumns + c] = regions->region(i);
        }
      }
    }
    std::vector<int> flood(region.size(), -1);
    std::map<std::uint32_t, int> name;
    std::map<std::uint32_t, std::uint32_t> area;
    int next = 0;
    const auto fill = [&](std::uint32_t start, int label) {
      std::vector<std::uint32_t> stack{start};
      flood[start] = label;
      while (!stack.empty()) {
        const std::uint32_t p = stack.back();
        stack.pop_back();
        const int c = static_cast<int>(p % kColumns);
        const int r = static_cast<int>(p / kColumns);
        const bool white = image.at(p % kColumns, p / kColumns);
        for (int dr = -1; dr <= 1; ++dr) {
          for (int dc = -1; dc <= 1; ++dc) {
            if (!white && dr != 0 && dc != 0) continue;
            const int nc = c + dc;
            const int nr = r + dr;
            if (nc < 0 || nr < 0 || nc >= static_cast<int>(kColumns) || nr >= static_cast<int>(kRows)) continue;
            const auto q = static_cast<std::uint32_t>(nr) * kColumns + static_cast<std::uint32_t>(nc);
            if (flood[q] >= 0 || image.at(q % kColumns, q / kColumns) != white) continue;
            flood[q] = label;
            stack.push_back(q);
          }
        }
      }
    };
    for (std::uint32_t p = 0; p < region.size(); ++p) {
      const bool border =
          p % kColumns == 0 || p % kColumns == kColumns - 1 || p / kColumns == 0 || p / kColumns == kRows - 1;
      if (border && !image.at(p % kColumns, p / kColumns) && flood[p] < 0) fill(p, 1000000);  // the outside is one
    }
    for (std::uint32_t p = 0; p < region.size(); ++p) {
      if (flood[p] < 0) fill(p, next++);
    }
    std::set<std::pair<std::uint32_t, int>> pairs;
    for (std::uint32_t p = 0; p < region.size(); ++p) {
      pairs.insert({region[p], flood[p]});
      ++area[region[p]];
    }
    std::set<std::uint32_t> ours;
    std::set<int> theirs;
    for (const auto& [a, b] : pairs) {
      ours.insert(a);
      theirs.insert(b);
      if (a != LayerRegions::kOutside) {
        EXPECT_EQ(regions->area(a), area[a]);
      }
    }
    EXPECT_EQ(pairs.size(), ours.size());
    EXPECT_EQ(pairs.size(), theirs.size());
  }
}

TEST(RRepEdit, TogglesAsASetOfVoxelsWould) {
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

// The print once began, and ended, with layers that had nothing but the tip of a stray, one pixel wide: the masks had none of it.
TEST(RRepEdit, TrimsLayersThatPrintNothingThough) {
  const auto spur = [](auto c, auto r, auto k) { return c == 20 && r == 20 && k >= 2; };
  const auto block_on_it = [](auto c, auto r, auto k) { return Block{10, 60, 5, 35, 0, 12}.has(c, r, k); };
  const auto passing = [](auto c, auto r, auto k) { return c == 30 && r == 9 && k >= 1 && k < 5; };
  Voxels voxels([&](auto c, auto r, auto k) {
    return spur(c, r, k) || passing(c, r, k) || (k >= 7 && block_on_it(c, r, k - 7));
  });
  expect_trimmed(voxels, 7, kLayers - 19);
  EXPECT_TRUE(voxels.equals([&](auto c, auto r, auto k) { return block_on_it(c, r, k) || (c == 20 && r == 20); }));
}

TEST(RRepEdit, FindsTheLastLayerBelowManyEmptyOnes) {
  const Inside low = [](auto c, auto r, auto k) { return Block{10, 60, 5, 35, 0, 2}.has(c, r, k); };
  ASSERT_GT(kLayers, 20U) << "more than are looked at first";
  Voxels voxels(low);
  expect_trimmed(voxels, 0, kLayers - 2);
  EXPECT_TRUE(voxels.equals(low));
}

TEST(RRepEdit, TrimsNothingWhereNoLayerPrints) {
  Voxels voxels([](auto c, auto r, auto k) { return c == 20 && r == 20 && k >= 2; });
  expect_trimmed(voxels, 0, 0);
}

}  // namespace
}  // namespace plumbline
