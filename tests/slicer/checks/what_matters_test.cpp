#include "slicer/checks/what_matters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slicer/checks/check_limits.hpp"

namespace plumbline {
namespace {

using ::testing::SizeIs;

/// A voxel has 0.000125 mm3.
constexpr PrintGrid kFine{
    .columns = 1000, .rows = 1000, .layers = 400, .pitch_x_mm = 0.05F, .pitch_y_mm = 0.05F, .layer_height_mm = 0.05F};

Issue issue(IssueKind kind, std::uint32_t first_layer, std::uint32_t last_layer, std::uint64_t voxels) {
  return {kind, first_layer, first_layer, last_layer, 500, 500, voxels / 4, voxels};
}

std::uint32_t told(const Issue& one, const AddedSupports& added = {}) {
  StackFindings findings;
  findings.of(one.kind).add(one);
  find_what_matters(findings, kFine, added);
  EXPECT_EQ(findings.count(one.kind), 1U) << "the manifest has all";
  EXPECT_THAT(findings.of(one.kind).told_kept(), SizeIs(findings.of(one.kind).told()));
  EXPECT_EQ(findings.any(), findings.of(one.kind).told() > 0);
  return findings.of(one.kind).told();
}

TEST(WhatMatters, LeavesOutWhatNobodyCouldSeeOnThePart) {
  EXPECT_EQ(told(issue(IssueKind::kResinTrap, 100, 110, 133)), 0U) << "0.0166 mm3";
  EXPECT_EQ(told(issue(IssueKind::kResinTrap, 100, 110, 799)), 0U);
  EXPECT_EQ(told(issue(IssueKind::kResinTrap, 100, 110, 801)), 1U) << "0.1 mm3";
  for (const IssueKind piece : {IssueKind::kFreePiece, IssueKind::kTear}) {
    EXPECT_EQ(told(issue(piece, 100, 110, 159)), 0U);
    EXPECT_EQ(told(issue(piece, 100, 110, 161)), 1U) << "0.02 mm3";
  }
  EXPECT_EQ(told(issue(IssueKind::kSuctionCup, 100, 110, 3999)), 0U);
  EXPECT_EQ(told(issue(IssueKind::kSuctionCup, 100, 110, 4001)), 1U) << "0.5 mm3";
  EXPECT_EQ(told(issue(IssueKind::kPlateTrap, 0, 110, 799'999)), 0U);
  EXPECT_EQ(told(issue(IssueKind::kPlateTrap, 0, 110, 800'001)), 1U) << "100 mm3";
  EXPECT_EQ(told(issue(IssueKind::kIsland, 100, 100, 1)), 1U) << "what grows on it may be large";
  EXPECT_EQ(told(issue(IssueKind::kUnreached, 100, 100, 4 * 279)), 0U);
  EXPECT_EQ(told(issue(IssueKind::kUnreached, 100, 100, 4 * 281)), 1U) << "0.7 mm2";
}

TEST(WhatMatters, TellsOfIslandsThatNoSupportReachesIfSomethingIsLost) {
  StackFindings findings;
  IssueGroup& islands = findings.of(IssueKind::kUnreachedIsland);
  islands.add(issue(IssueKind::kUnreachedIsland, 100, 100, 4));
  islands.count = 3;
  findings.of(IssueKind::kFreePiece).add(issue(IssueKind::kFreePiece, 100, 101, 100));
  find_what_matters(findings, kFine, {.drawn = true});
  EXPECT_EQ(islands.told(), 0U) << "0.0125 mm3 fall";
  findings.of(IssueKind::kFreePiece).add(issue(IssueKind::kFreePiece, 100, 110, 161));
  find_what_matters(findings, kFine, {.drawn = true});
  EXPECT_EQ(islands.told(), 3U);
}

TEST(WhatMatters, LeavesOutWhatOnlySupportsCause) {
  const AddedSupports raft{.drawn = true, .raft_layers = 100, .object_clear = true};
  EXPECT_EQ(told(issue(IssueKind::kIsland, 200, 200, 400), raft), 0U) << "what falls from it is told";
  for (const IssueKind kind : {IssueKind::kResinTrap, IssueKind::kSuctionCup, IssueKind::kPlateTrap,
                               IssueKind::kFirstLayerArea, IssueKind::kPeelArea, IssueKind::kPeelJump}) {
    EXPECT_EQ(told(issue(kind, 0, 99, 1'000'000), raft), 0U) << words_of(kind).key;
    EXPECT_EQ(told(issue(kind, 0, 100, 1'000'000), raft), 1U) << words_of(kind).key << " reaches the object";
    EXPECT_EQ(told(issue(kind, 0, 99, 1'000'000)), 1U) << words_of(kind).key << " of a foreign archive";
  }
  EXPECT_EQ(told(issue(IssueKind::kTouchingBound, 0, 20, 9000), raft), 0U);
  EXPECT_EQ(
      told(issue(IssueKind::kTouchingBound, 0, 20, 9000), {.drawn = true, .raft_layers = 100, .object_clear = false}),
      1U);
  for (const IssueKind kind : {IssueKind::kFreePiece, IssueKind::kTear, IssueKind::kPrintHeight}) {
    EXPECT_EQ(told(issue(kind, 0, 50, 1'000'000), raft), 1U) << words_of(kind).key << " does harm, whatever it is of";
  }
}

TEST(WhatMatters, PutsWhatIsToldFirst) {
  StackFindings findings;
  IssueGroup& cups = findings.of(IssueKind::kSuctionCup);
  cups.add(issue(IssueKind::kSuctionCup, 0, 50, 90'000));  // in the raft
  cups.add(issue(IssueKind::kSuctionCup, 200, 250, 50'000));
  cups.add(issue(IssueKind::kSuctionCup, 300, 310, 100));  // a speck
  find_what_matters(findings, kFine, {.drawn = true, .raft_layers = 100, .object_clear = true});
  EXPECT_EQ(cups.count, 3U);
  EXPECT_EQ(cups.told(), 1U);
  EXPECT_EQ(cups.kept[0].voxels, 50'000U);
  EXPECT_EQ(cups.all_kept().size(), 3U);
}

TEST(WhatMatters, CountsSmallOnesThatAreNotKept) {
  StackFindings findings;
  IssueGroup& traps = findings.of(IssueKind::kResinTrap);
  for (int i = 0; i < 50; ++i) traps.add(issue(IssueKind::kResinTrap, 100, 110, 100));
  for (int i = 0; i < 3; ++i) traps.add(issue(IssueKind::kResinTrap, 100, 110, 10'000));
  find_what_matters(findings, kFine, {});
  EXPECT_EQ(traps.count, 53U);
  EXPECT_EQ(traps.told(), 3U);
  for (int i = 0; i < 50; ++i) traps.add(issue(IssueKind::kResinTrap, 100, 110, 10'000));
  find_what_matters(findings, kFine, {});
  EXPECT_EQ(traps.told(), 103U) << "eight are kept, all of which matter";
}

TEST(WhatMatters, KnowsTheMarginOfTheCheck) { EXPECT_EQ(CheckLimits{}.bound_margin, kEdgeMargin); }

}  // namespace
}  // namespace plumbline
