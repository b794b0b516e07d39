/// What a print with supports is told of, from its masks and from what no support reaches.

#include "slicer/support_building.hpp"

#include <gtest/gtest.h>

#include "tests/slicer/checks/checked_stack.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline {
namespace support_building_test {

using namespace testing;

/// A solid of pixels of 0.1 mm with the supports found for it, and what is found in its masks.
struct Checked {
  Checked(const PrintGrid& grid, const Inside& inside, const SupportSettings& settings = {}) {
    Solid solid(grid, inside);
    ArenaBlock arena(64 * kMiB);
    solid.move_to(*arena);
    const Supports supports =
        value_of(find_supports(solid.rrep, settings, PrintGrid::kMaxLayers, *arena, nullptr, counts));
    const auto masks = solid.masks(&supports);
    findings = check(masks, {});
    SliceReport report;
    report.placement.grid = solid.rrep.grid;
    finish_findings(findings, supports, counts, report);
  }
  SupportCounts counts;
  StackFindings findings;
};

TEST(FinishFindings, TellsWhereAnIslandHangsThatNoSupportReaches) {
  // A drop in a shaft 1.6 mm wide and 8 mm deep: every pillar would stand nearer than a millimetre to its walls, and these are too thin
  // for the foot of a pin.
  const Checked print(cubic_grid(120, 110), [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const bool shaft = c >= 52 && c < 68 && r >= 52 && r < 68;
    const bool block = c >= 49 && c < 71 && r >= 49 && r < 71 && (!shaft || k < 10);
    return (block && k < 100) || ball(60, 60, 94, 5)(c, r, k);
  });
  const IssueGroup& islands = print.findings.of(IssueKind::kUnreachedIsland);
  ASSERT_EQ(islands.told(), 1U);
  EXPECT_EQ(islands.kept[0].layer, 89U + print.counts.lifted) << "the ball's lowest layer";
  EXPECT_NEAR(islands.kept[0].column, 60, 2);
  EXPECT_NEAR(islands.kept[0].row, 60, 2);
  EXPECT_EQ(print.findings.count(IssueKind::kUnreached), 0U);
}

TEST(FinishFindings, TellsTheLargestOverhangThatNoSupportReaches) {
  SupportCounts counts;
  for (const std::uint32_t load : {30U, 250U, 90U}) {
    const auto at = static_cast<std::uint16_t>(load);
    counts.unreached_overhangs.add({.column = at, .row = 7, .layer = at, .load = load});
  }
  StackFindings findings;
  SliceReport report;
  report.placement.grid = cubic_grid(300, 300);
  finish_findings(findings, {}, counts, report);
  const IssueGroup& places = findings.of(IssueKind::kUnreached);
  EXPECT_EQ(places.count, 3U);
  EXPECT_EQ(places.told(), 3U);
  EXPECT_EQ(places.all_kept().size(), 1U);
  EXPECT_EQ(places.kept[0], (Issue{IssueKind::kUnreached, 250, 250, 250, 250, 7, 250, 250}));
  EXPECT_EQ(findings.count(IssueKind::kUnreachedIsland), 0U);
}

TEST(FinishFindings, HasNothingToSayIfEveryPlaceIsReached) {
  const Checked print(cubic_grid(260, 70), ball(130, 130, 50, 20));
  EXPECT_GT(print.counts.all(), 0U);
  for (const IssueGroup& group : print.findings.groups) {
    EXPECT_EQ(group.told(), 0U) << words_of(group.kept[0].kind).key << " in layer " << group.kept[0].layer
                                << ", pixels " << group.kept[0].pixels;
  }
}

TEST(FinishFindings, TellsOfNoPillarThatItIsANeedleButOfAColumnThatIs) {
  // A block 45 mm above the plate on pillars of 0.4 mm without braces; on it a column of 0.3 mm, 30 mm high.
  SupportSettings settings;
  settings.object_elevation = 45;
  settings.stand = SupportStand::kRaised;
  settings.pillar_diameter = 0.4;
  settings.max_pillar_link_distance = 0;
  const Inside block = blocks({{40, 60, 40, 60, 0, 20}});
  const Checked pillars(cubic_grid(110, 20), block, settings);
  EXPECT_GT(pillars.findings.count(IssueKind::kNeedle), 0U) << "the pillars are";
  EXPECT_EQ(pillars.findings.of(IssueKind::kNeedle).told(), 0U);
  EXPECT_EQ(pillars.findings.count(IssueKind::kThinWall), 0U);
  const Checked column(cubic_grid(110, 320), blocks({{40, 60, 40, 60, 0, 20}, {48, 51, 48, 51, 20, 320}}), settings);
  ASSERT_EQ(column.findings.of(IssueKind::kNeedle).told(), 1U);
  EXPECT_EQ(column.findings.of(IssueKind::kNeedle).kept[0].column, 49U);
}

}  // namespace support_building_test
}  // namespace plumbline
