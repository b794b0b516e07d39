#include "slicer/checks/stack_checker.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "tests/slicer/checks/checked_stack.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr std::uint32_t kSide = 100;

/// The only issue of a kind.
Issue only(const StackFindings& findings, IssueKind kind) {
  const IssueGroup& group = findings.of(kind);
  EXPECT_EQ(group.count, 1U) << words_of(kind).key;
  return group.count > 0 ? group.kept[0] : Issue{};
}

std::uint32_t all_issues(const StackFindings& findings) {
  std::uint32_t sum = 0;
  for (const IssueGroup& group : findings.groups) sum += group.count;
  return sum;
}

TEST(StackChecker, FindsNothingInABlock) {
  const auto findings = check(stack_of(kSide, 20, blocks({{20, 70, 20, 70, 0, 20}})), {});
  EXPECT_EQ(all_issues(findings), 0U);
  EXPECT_FALSE(findings.any());
  EXPECT_EQ(findings.layers, 20U);
  EXPECT_EQ(findings.voxels, 50U * 50 * 20);
  EXPECT_EQ(findings.first_layer_pixels, 2500U);
  EXPECT_EQ(findings.peel_pixels, 2500U);
}

TEST(StackChecker, FindsTheSameWhileTheNextMaskIsDrawnOverTheOneThatItChecks) {
  const auto masks =
      stack_of(kSide, 15, blocks({{10, 30, 10, 60, 0, 15}, {50, 60, 20, 24, 5, 15}, {30, 50, 20, 24, 12, 15}}));
  const auto findings = check(masks, {});
  EXPECT_EQ(all_issues(findings), 2U);
  for (const int threads : {1, 2, 3}) {
    const int usual = omp_get_max_threads();
    omp_set_num_threads(threads);
    const PrintGrid grid = grid_of(masks);
    ArenaBlock arena(16 * kMiB);
    StackChecker checker = value_of(StackChecker::create(grid, {}, *arena));
    OwnedImage mask = masks[0].image();
    for (std::size_t k = 0; k < masks.size(); ++k) {
      checker.take(mask.view());
      int drawn = 0;
      checker.check_while([&] {
        ++drawn;
        std::ranges::fill(mask.view().words(), ~std::uint64_t{0});
        if (k + 1 < masks.size()) mask = masks[k + 1].image();
      });
      EXPECT_EQ(drawn, 1);
    }
    omp_set_num_threads(usual);
    const StackFindings same = checker.finish();
    EXPECT_EQ(same.voxels, findings.voxels);
    EXPECT_EQ(all_issues(same), 2U);
    for (const IssueKind kind : {IssueKind::kIsland, IssueKind::kFreePiece})
      EXPECT_EQ(only(same, kind), only(findings, kind));
  }
}

TEST(StackChecker, FindsAnIslandAndThePieceAboveItUntilItJoinsTheRest) {
  // A wall, and beside it a block that begins in layer 5 and is joined by a bridge in layers 12 to 14.
  const auto findings = check(
      stack_of(kSide, 15, blocks({{10, 30, 10, 60, 0, 15}, {50, 60, 20, 24, 5, 15}, {30, 50, 20, 24, 12, 15}})), {});
  const Issue island = only(findings, IssueKind::kIsland);
  EXPECT_EQ(island, (Issue{IssueKind::kIsland, 5, 5, 5, 55, 20, 40, 40}));
  const Issue piece = only(findings, IssueKind::kFreePiece);
  EXPECT_EQ(piece.first_layer, 5U);
  EXPECT_EQ(piece.last_layer, 11U);  // what is above hangs on the bridge
  EXPECT_EQ(piece.voxels, 40U * 7);
  EXPECT_NEAR(findings.fallen_share(), 280.0 / static_cast<double>(findings.voxels), 1e-12);
}

TEST(StackChecker, FindsIslandsThatALittleHolds) {
  // 12 of 40 pixels hold the first, 9 the second, which is less than a quarter.
  const auto findings = check(
      stack_of(
          kSide, 2,
          blocks({{10, 16, 10, 12, 0, 1}, {10, 30, 10, 12, 1, 2}, {10, 19, 50, 51, 0, 1}, {10, 30, 50, 52, 1, 2}})),
      {});
  const Issue island = only(findings, IssueKind::kIsland);
  EXPECT_EQ(island.row, 50U);
  EXPECT_EQ(findings.count(IssueKind::kFreePiece), 0U);  // it is held
}

TEST(StackChecker, LetsATenthOfAWideRegionHoldItUnlessItOverhangs) {
  // 4 x 4 of 14 x 14 pixels: a share of 0.08. The rest reaches 5 pixels to each side. Posts widen the layers' box.
  const auto masks = stack_of(
      kSide, 2, blocks({{0, 2, 0, 2, 0, 2}, {98, 100, 98, 100, 0, 2}, {45, 49, 45, 49, 0, 1}, {40, 54, 40, 54, 1, 2}}));
  CheckLimits limits;
  EXPECT_EQ(check(masks, limits).count(IssueKind::kIsland), 0U);
  limits.overhang_reach = 2;
  const auto findings = check(masks, limits);
  EXPECT_EQ(findings.count(IssueKind::kIsland), 1U);
  EXPECT_GT(findings.count(IssueKind::kOverhang), 0U);
}

/// In layer 0 posts of 3 x 3 pixels as far apart as asked, in layer 1 a plate on them. Pixels of 0.1 mm.
std::vector<Pixels> plate_on_posts(std::uint32_t apart, std::uint32_t columns_with_posts) {
  return stack_of(kSide, 2, [=](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const bool post = c % apart >= apart / 2 && c % apart < apart / 2 + 3 && r % apart >= apart / 2 &&
                      r % apart < apart / 2 + 3 && c < columns_with_posts;
    return c >= 5 && c < 95 && r >= 5 && r < 95 && (k == 1 || post);
  });
}

TEST(StackChecker, FindsNoIslandThatRestsOnTipsAllOver) {
  // 9 of 225 pixels are held, 4 %.
  EXPECT_EQ(check(plate_on_posts(15, kSide), {}).count(IssueKind::kIsland), 0U);
  // 9 of 900, less than a ninetieth.
  EXPECT_EQ(check(plate_on_posts(30, kSide), {}).count(IssueKind::kIsland), 1U);
  // Posts 1.5 mm apart, none below the last 3.4 mm.
  EXPECT_EQ(check(plate_on_posts(15, 60), {}).count(IssueKind::kIsland), 1U);
  // In finer pixels the posts have 0.02 mm2 each, but touch 4 % all the same, and are nearer.
  EXPECT_EQ(check(plate_on_posts(15, kSide), {}, 0.05F).count(IssueKind::kIsland), 0U);
}

TEST(StackChecker, FindsTheIslandBesideTipsOfAnotherRegion) {
  // A strip of 1 x 4 mm stands on two posts at its end. Along it, half a millimetre aside, is a wall.
  const auto masks = stack_of(
      kSide, 2,
      blocks({{10, 13, 10, 13, 0, 1}, {16, 19, 10, 13, 0, 1}, {10, 20, 10, 50, 1, 2}, {25, 35, 10, 90, 0, 2}}));
  EXPECT_EQ(only(check(masks, {}), IssueKind::kIsland).pixels, 400U);
}

TEST(StackChecker, FindsASmallIslandThatTouchesLessThanATip) {
  // 10 of 288 pixels are held, a twenty-ninth, all nearer than 2.6 mm: 0.025 mm2 with pixels of 0.05 mm.
  const auto masks =
      stack_of(kSide, 2, blocks({{40, 45, 40, 41, 0, 1}, {50, 55, 40, 41, 0, 1}, {34, 58, 36, 48, 1, 2}}));
  EXPECT_EQ(check(masks, {}, 0.05F).count(IssueKind::kIsland), 1U);
  EXPECT_EQ(check(masks, {}, 0.1F).count(IssueKind::kIsland), 0U);
}

TEST(StackChecker, ForetellsThatAThinNeckTearsWhenAPlateBelowItIsPeeled) {
  // A neck of 0.09 mm2 holds 0.45 N. A plate of 4 x 4 mm needs 0.08 N for its area and 0.03 N/mm pi / 4 16 mm for its outline.
  const auto masks =
      stack_of(60, 15, blocks({{20, 40, 20, 40, 0, 5}, {28, 31, 28, 31, 5, 10}, {10, 50, 10, 50, 10, 15}}));
  const StackFindings findings = check(masks, {});
  const Issue tear = only(findings, IssueKind::kTear);
  EXPECT_EQ(std::tuple(tear.layer, tear.first_layer, tear.last_layer, tear.column, tear.row),
            std::tuple(5U, 5U, 14U, 29U, 28U));
  EXPECT_EQ(tear.pixels, 1600U);
  EXPECT_EQ(tear.voxels, 5U * 9 + 5 * 1600);
  EXPECT_NEAR(static_cast<double>(tear.asked_n), 0.457, 0.001);
  EXPECT_NEAR(static_cast<double>(tear.held_n), 0.45, 0.001);
  EXPECT_EQ(findings.count(IssueKind::kFreePiece), 0U);

  CheckLimits tough;
  tough.peel.green_strength_mpa = 5.2;
  EXPECT_EQ(check(masks, tough).count(IssueKind::kTear), 0U);
}

TEST(StackChecker, FindsAnOverhangBeyondTheReach) {
  // A shelf 60 pixels long. Pixels more than 40 beyond the wall are left: 20 of them in 30 rows.
  const auto masks = stack_of(kSide, 2, blocks({{10, 20, 10, 40, 0, 2}, {20, 80, 10, 40, 1, 2}}));
  const Issue overhang = only(check(masks, {}), IssueKind::kOverhang);
  EXPECT_EQ(overhang.layer, 1U);
  EXPECT_EQ(overhang.pixels, 20U * 30);
  EXPECT_EQ(overhang.column, 70U);
  EXPECT_EQ(check(stack_of(kSide, 2, blocks({{10, 20, 10, 40, 0, 2}, {20, 60, 10, 40, 1, 2}})), {})
                .count(IssueKind::kOverhang),
            0U);
}

TEST(StackChecker, FindsNoOverhangWhoseContourEnclosesLessThanAPixel) {
  CheckLimits limits;
  limits.overhang_reach = 0;  // all new pixels are overhangs
  const auto overhangs = [&](const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pixels) {
    std::vector<Pixels> masks(2, Pixels(kSide, kSide));
    for (const auto& [c, r] : pixels) masks[1].set(62 + c, 40 + r, true);
    return check(masks, limits).count(IssueKind::kOverhang);
  };
  EXPECT_EQ(overhangs({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}}), 0U);          // a line
  EXPECT_EQ(overhangs({{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}}), 0U);          // across
  EXPECT_EQ(overhangs({{0, 0}, {1, 0}, {2, 0}, {2, 1}}), 0U);                  // half a pixel in the corner
  EXPECT_EQ(overhangs({{0, 0}, {1, 0}, {1, 1}, {2, 1}}), 1U);                  // half in each of two
  EXPECT_EQ(overhangs({{0, 0}, {1, 0}, {0, 1}, {1, 1}}), 1U);                  // a square
  EXPECT_EQ(overhangs({{1, 0}, {0, 1}, {1, 1}, {2, 1}, {1, 2}, {5, 0}}), 1U);  // a plus, and a pixel
}

TEST(StackChecker, FindsAResinTrap) {
  const auto masks = stack_of(kSide, 20, without(blocks({{20, 60, 20, 60, 0, 20}}), blocks({{30, 50, 30, 40, 5, 15}})));
  const auto findings = check(masks, {});
  const Issue trap = only(findings, IssueKind::kResinTrap);
  EXPECT_EQ(trap, (Issue{IssueKind::kResinTrap, 5, 5, 14, 40, 30, 200, 2000}));
  EXPECT_EQ(findings.count(IssueKind::kSuctionCup), 0U);
}

TEST(StackChecker, IsSilentAboutATrapOfSixteenPixels) {
  const auto with_hole = [](std::uint32_t width) {
    return stack_of(kSide, 20, without(blocks({{20, 60, 20, 60, 0, 20}}), blocks({{30, 30 + width, 30, 31, 5, 15}})));
  };
  EXPECT_EQ(check(with_hole(16), {}).count(IssueKind::kResinTrap), 0U);
  EXPECT_EQ(check(with_hole(17), {}).count(IssueKind::kResinTrap), 1U);
}

TEST(StackChecker, IsSilentAboutAGapThatTheNextLayersLightCures) {
  const auto with_hollow = [](std::uint32_t layers) {
    return stack_of(kSide, 20, without(blocks({{20, 60, 20, 60, 0, 20}}), blocks({{30, 50, 30, 40, 5, 5 + layers}})));
  };
  CheckLimits limits;
  limits.cured_gap_mm = 0.25;  // layers of 0.1 mm
  EXPECT_EQ(check(with_hollow(2), limits).count(IssueKind::kResinTrap), 0U);
  EXPECT_EQ(check(with_hollow(3), limits).count(IssueKind::kResinTrap), 1U);
  EXPECT_EQ(check(with_hollow(1), {}).count(IssueKind::kResinTrap), 1U) << "UVtools' rule";
}

TEST(StackChecker, FindsASuctionCupThatOpensUpwards) {
  const auto findings =
      check(stack_of(kSide, 20, without(blocks({{20, 60, 20, 60, 0, 20}}), blocks({{30, 50, 30, 40, 5, 20}}))), {});
  const Issue cup = only(findings, IssueKind::kSuctionCup);
  EXPECT_EQ(cup.first_layer, 5U);
  EXPECT_EQ(cup.last_layer, 19U);
  EXPECT_EQ(cup.voxels, 200U * 15);
  EXPECT_EQ(findings.count(IssueKind::kResinTrap), 0U);
}

TEST(StackChecker, FindsTheSuctionOfABowlUpsideDown) {
  // Its rim stands on the plate, so the hollow is closed from layer 0 on, and its roof closes it before it is taken off.
  const auto bowl = stack_of(kSide, 20, without(blocks({{20, 60, 20, 60, 0, 20}}), blocks({{30, 50, 30, 40, 0, 15}})));
  const auto findings = check(bowl, {}, 0.4F);  // 32 mm2
  const Issue cup = only(findings, IssueKind::kSuctionCup);
  EXPECT_EQ(cup.voxels, 200U * 15);
  EXPECT_EQ(findings.count(IssueKind::kResinTrap), 0U);
}

TEST(StackChecker, FindsAHollowThatDrainsOnlyAtThePlate) {
  const auto with_hollow = [](const std::vector<Block>& hollow) {
    return check(stack_of(kSide, 20, without(blocks({{20, 60, 20, 60, 0, 20}}), blocks(hollow))), {});
  };
  // 2 mm2: what sucks in it is too little to tell of.
  const auto cup = with_hollow({{30, 50, 30, 40, 0, 15}});
  EXPECT_EQ(only(cup, IssueKind::kPlateTrap), (Issue{IssueKind::kPlateTrap, 0, 0, 14, 40, 30, 200, 3000}));
  EXPECT_EQ(cup.count(IssueKind::kSuctionCup), 0U);
  EXPECT_EQ(with_hollow({{30, 50, 30, 40, 0, 20}}).count(IssueKind::kPlateTrap), 0U) << "it opens at the top";
  EXPECT_EQ(with_hollow({{30, 50, 30, 40, 0, 15}, {10, 30, 33, 37, 5, 8}}).count(IssueKind::kPlateTrap), 0U)
      << "a hole";
  EXPECT_EQ(with_hollow({{30, 50, 30, 40, 1, 15}}).count(IssueKind::kPlateTrap), 0U) << "a resin trap";
}

TEST(StackChecker, IsSilentAboutASmallHoleOfARaft) {
  // 10 layers of raft with a hole of 200 pixels that ends at the raft's top; a pillar goes on.
  const auto raft =
      stack_of(kSide, 20,
               without(blocks({{20, 60, 20, 60, 0, 10}, {22, 28, 22, 28, 10, 20}}), blocks({{30, 50, 30, 40, 0, 10}})));
  EXPECT_EQ(check(raft, {}, 0.1F).count(IssueKind::kSuctionCup), 0U);   // 2 mm2
  EXPECT_EQ(check(raft, {}, 0.35F).count(IssueKind::kSuctionCup), 0U);  // 24.5 mm2
  EXPECT_EQ(check(raft, {}, 0.36F).count(IssueKind::kSuctionCup), 1U);  // 25.9 mm2
  // A tube on the plate.
  const auto tube = stack_of(kSide, 20, without(blocks({{20, 60, 20, 60, 0, 20}}), blocks({{30, 50, 30, 40, 0, 20}})));
  EXPECT_EQ(check(tube, {}, 0.35F).count(IssueKind::kSuctionCup), 0U);
  EXPECT_EQ(only(check(tube, {}, 0.36F), IssueKind::kSuctionCup).voxels, 200U * 20);
}

TEST(StackChecker, KnowsThatAHoleNearThePlateVentsACup) {
  const auto findings = check(
      stack_of(kSide, 20,
               without(blocks({{20, 60, 20, 60, 0, 20}}), blocks({{30, 50, 30, 40, 5, 20}, {10, 30, 33, 37, 5, 8}}))),
      {});
  EXPECT_EQ(findings.count(IssueKind::kSuctionCup), 0U);
}

TEST(StackChecker, KnowsThatAHoleFarFromThePlateComesTooLate) {
  const auto findings = check(
      stack_of(kSide, 20,
               without(blocks({{20, 60, 20, 60, 0, 20}}), blocks({{30, 50, 30, 40, 5, 20}, {10, 30, 33, 37, 12, 15}}))),
      {});
  const Issue cup = only(findings, IssueKind::kSuctionCup);
  EXPECT_EQ(cup.first_layer, 5U);
  EXPECT_EQ(cup.last_layer, 11U);  // vented from layer 12 on
}

TEST(StackChecker, FollowsASiphon) {
  // Two shafts, joined at their lower ends; one of them opens to the side half way. The other is vented through it.
  const auto findings = check(stack_of(kSide, 20,
                                       without(blocks({{20, 70, 20, 60, 0, 20}}), blocks({{25, 35, 25, 45, 8, 20},
                                                                                          {50, 60, 25, 45, 8, 20},
                                                                                          {25, 60, 25, 45, 5, 8},
                                                                                          {60, 80, 30, 40, 12, 15}}))),
                              {});
  const Issue cup = only(findings, IssueKind::kSuctionCup);
  EXPECT_EQ(cup.last_layer, 11U);
  EXPECT_EQ(cup.voxels, 35U * 20 * 3 + 2U * 10 * 20 * 4);
}

TEST(StackChecker, LetsNothingDrainThroughAnOpeningOfNinePixels) {
  const auto hollow = [](std::uint32_t width) {
    // A hollow in layers 5 to 9 whose only opening goes straight down.
    return stack_of(kSide, 20,
                    without(blocks({{20, 60, 20, 60, 2, 20}, {20, 25, 20, 25, 0, 2}}),
                            blocks({{30, 50, 30, 40, 5, 10}, {35, 35 + width, 33, 36, 2, 5}})));
  };
  EXPECT_EQ(check(hollow(3), {}).count(IssueKind::kResinTrap), 1U);
  EXPECT_EQ(check(hollow(4), {}).count(IssueKind::kResinTrap), 0U);
}

TEST(StackChecker, CountsTheNarrowEndOfAHollowAsPartOfIt) {
  const auto findings =
      check(stack_of(kSide, 20,
                     without(blocks({{20, 60, 20, 60, 0, 20}}),
                             blocks({{30, 50, 30, 40, 8, 12}, {38, 40, 33, 36, 5, 8}, {38, 40, 33, 36, 12, 15}}))),
            {});
  EXPECT_EQ(only(findings, IssueKind::kResinTrap).voxels, 200U * 4 + 2 * 6 * 3);
}

TEST(StackChecker, FindsWhatTouchesThePanelsEdge) {
  CheckLimits limits;
  limits.has_panel = true;
  const auto masks = stack_of(kSide, 10, blocks({{4, 50, 20, 60, 0, 10}, {50, 60, 90, 97, 0, 10}}));
  const Issue bound = only(check(masks, limits), IssueKind::kTouchingBound);
  EXPECT_EQ(bound.pixels, 40U + 20U);  // one column, two rows
  EXPECT_EQ(bound.first_layer, 0U);
  EXPECT_EQ(bound.last_layer, 9U);
  EXPECT_EQ(bound.column, 4U);
  EXPECT_EQ(check(stack_of(kSide, 10, blocks({{5, 95, 5, 95, 0, 10}})), limits).count(IssueKind::kTouchingBound), 0U);
  limits.has_panel = false;
  EXPECT_EQ(check(masks, limits).count(IssueKind::kTouchingBound), 0U);
}

TEST(StackChecker, FindsGapsOfEmptyLayers) {
  const auto findings = check(stack_of(kSide, 20, blocks({{20, 60, 20, 60, 2, 8}, {20, 60, 20, 60, 11, 18}})), {});
  const IssueGroup& gaps = findings.of(IssueKind::kEmptyLayer);
  ASSERT_EQ(gaps.count, 3U);
  EXPECT_EQ(gaps.kept[0].first_layer, 8U);  // the largest
  EXPECT_EQ(gaps.kept[0].last_layer, 10U);
  EXPECT_EQ(gaps.kept[1].first_layer, 0U);
  EXPECT_EQ(gaps.kept[2].last_layer, 19U);
  EXPECT_EQ(findings.count(IssueKind::kFreePiece), 2U);
}

TEST(StackChecker, FindsLayersAboveTheTravel) {
  CheckLimits limits;
  limits.travel_mm = 1.5;
  const auto masks = stack_of(kSide, 20, blocks({{20, 60, 20, 60, 0, 20}}));
  const Issue issue = only(check(masks, limits), IssueKind::kPrintHeight);
  EXPECT_EQ(issue.first_layer, 15U);
  EXPECT_EQ(issue.last_layer, 19U);
  limits.travel_mm = 2;
  EXPECT_EQ(check(masks, limits).count(IssueKind::kPrintHeight), 0U);
}

TEST(StackChecker, FindsASmallFirstLayerALargeLayerAndAJump) {
  CheckLimits limits;
  limits.peel_mm2 = 20;
  limits.peel_jump_mm2 = 10;
  const auto findings = check(
      stack_of(kSide, 10, blocks({{20, 50, 20, 50, 0, 4}, {20, 70, 20, 70, 4, 10}, {70, 75, 20, 30, 6, 10}})), limits);
  EXPECT_EQ(only(findings, IssueKind::kFirstLayerArea).pixels, 900U);  // 9 mm2
  const Issue peel = only(findings, IssueKind::kPeelArea);
  EXPECT_EQ(peel.first_layer, 4U);
  EXPECT_EQ(peel.layer, 6U);
  EXPECT_EQ(peel.last_layer, 9U);
  EXPECT_EQ(peel.pixels, 2550U);
  const Issue jump = only(findings, IssueKind::kPeelJump);
  EXPECT_EQ(jump.layer, 4U);
  EXPECT_EQ(jump.pixels, 1600U);
  EXPECT_EQ(findings.jump_layer, 4U);
  EXPECT_EQ(findings.peel_pixels, 2550U);
}

TEST(StackChecker, SaysWhichLayersAreTooFineAndGoesOn) {
  // A checkerboard has more runs than there is room for. What stands on it counts as held.
  auto masks = stack_of(200, 6, blocks({{20, 180, 20, 180, 0, 6}}));
  for (std::uint32_t r = 0; r < 200; ++r) {
    for (std::uint32_t c = 0; c < 200; ++c) masks[2].set(c, r, (c + r) % 2 == 0);
  }
  masks[4].set(5, 5, true);
  const auto findings = check(masks, {});
  EXPECT_EQ(findings.unchecked_layers, 1U);
  EXPECT_TRUE(findings.any());
  EXPECT_EQ(only(findings, IssueKind::kIsland).layer, 4U);
}

TEST(StackChecker, KeepsTheLargestIssuesAndCountsAll) {
  std::vector<Block> all = {{0, 90, 0, 2, 0, 3}};
  for (std::uint32_t i = 0; i < 12; ++i) all.push_back({5 * i, 5 * i + 1 + i % 4, 20, 22, 1, 3});
  const auto findings = check(stack_of(kSide, 3, blocks(all)), {});
  const IssueGroup& islands = findings.of(IssueKind::kIsland);
  EXPECT_EQ(islands.count, 12U);
  EXPECT_EQ(islands.pixels, 2U * 3 * (1 + 2 + 3 + 4));
  ASSERT_EQ(islands.kept_count, IssueGroup::kKept);
  for (std::size_t i = 0; i < IssueGroup::kKept; ++i) EXPECT_EQ(islands.kept[i].pixels, i < 3 ? 8U : i < 6 ? 6U : 4U);
}

CheckLimits as_the_finder() {
  CheckLimits limits;
  limits.overhangs = OverhangRule::kNeedSupport;
  return limits;
}

/// A post of 4 x 8 mm, 8 mm high, and an arm that juts out of its upper half by `grows` pixels a layer: layers of 0.1 mm.
std::vector<Pixels> arm(std::uint32_t grows, std::uint32_t longest) {
  return stack_of(200, 80, [=](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const std::uint32_t out = k < 40 ? 0 : std::min((k - 39) * grows, longest);
    return c >= 20 && c < 60 + out && r >= 20 && r < 100;
  });
}

TEST(StackCheckerOverhangs, NeedSupportWhereTheFinderWouldPutATip) {
  // 10 degrees: 0.57 mm a layer, which UVtools' plus of 4 mm never fits into.
  const auto flat = arm(6, 100);
  EXPECT_EQ(check(flat, {}).count(IssueKind::kOverhang), 0U);
  const StackFindings found = check(flat, as_the_finder());
  const IssueGroup& overhangs = found.of(IssueKind::kOverhang);
  // The arm gains 0.5 mm a layer on what is held: 2.5 mm of it are passed in the fifth layer, then again and again.
  ASSERT_GE(overhangs.count, 2U);
  EXPECT_LE(overhangs.count, 5U);
  std::uint32_t lowest = ~0U;
  for (const Issue& issue : overhangs.all_kept()) {
    lowest = std::min(lowest, issue.layer);
    EXPECT_GE(issue.column, 60U + 25U);
    EXPECT_EQ(issue.pixels % 80, 0U) << "columns as wide as the arm";
  }
  EXPECT_NEAR(lowest, 44, 1);
}

TEST(StackCheckerOverhangs, NeedNoSupportUpToHalfABridgeAndAtFortyFiveDegrees) {
  EXPECT_EQ(check(arm(24, 24), as_the_finder()).count(IssueKind::kOverhang), 0U) << "2.4 mm at once";
  EXPECT_EQ(check(arm(30, 30), as_the_finder()).count(IssueKind::kOverhang), 1U) << "3 mm at once";
  EXPECT_EQ(check(arm(1, 100), as_the_finder()).count(IssueKind::kOverhang), 0U) << "45 degrees";
}

TEST(StackCheckerOverhangs, AreNotToldWhereAnIslandIs) {
  const auto masks = stack_of(200, 60, blocks({{20, 60, 20, 60, 0, 60}, {100, 160, 20, 80, 30, 60}}));
  const StackFindings found = check(masks, as_the_finder());
  EXPECT_EQ(found.count(IssueKind::kIsland), 1U);
  EXPECT_EQ(found.count(IssueKind::kFreePiece), 1U);
  EXPECT_EQ(found.count(IssueKind::kOverhang), 0U);
}

TEST(StackCheckerOverhangs, AreNoneByTheFinderIfItsTipsAreInTheMasks) {
  CheckLimits limits;
  limits.overhangs = OverhangRule::kNone;
  limits.overhang_reach = 1;
  EXPECT_EQ(check(arm(30, 30), limits).count(IssueKind::kOverhang), 0U);
}

TEST(StackChecker, RefusesAnArenaThatIsTooSmall) {
  const PrintGrid grid = cubic_grid(64, 4);
  ArenaBlock arena(StackChecker::bytes_needed(grid) - Arena::kAlignment);
  const auto refused = StackChecker::create(grid, {}, *arena);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kOutOfMemory);
}

}  // namespace
}  // namespace plumbline
