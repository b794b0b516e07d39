// Supports that a person adds, and areas that a person keeps free of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "slicer/slicer.hpp"
#include "slicer/support_building.hpp"
#include "slicer/supports/support_finder.hpp"
#include "tests/slicer/checks/checked_stack.hpp"
#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline {
namespace placed_supports_test {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::uint32_t kSide = 64;  // pixels of 0.1 mm, layers of 0.1 mm

SupportSettings on_the_plate(std::vector<SupportPlace> added = {}, std::vector<SupportPlace> blocked = {}) {
  SupportSettings settings;
  settings.object_elevation = 0;
  for (const SupportPlace& place : added) settings.added.list[settings.added.count++] = place;
  for (const SupportPlace& ball : blocked) settings.blocked.list[settings.blocked.count++] = ball;
  return settings;
}

/// A solid of boxes with the supports found for it.
struct Held {
  Held(const std::vector<Block>& boxes, const SupportSettings& settings, std::uint32_t side = kSide)
      : solid(cubic_grid(side, 48), blocks(boxes)), arena(32 * kMiB) {
    solid.move_to(*arena);
    supports = value_of(find_supports(solid.rrep, settings, PrintGrid::kMaxLayers, *arena, nullptr, counts));
    masks = solid.masks(&supports);
  }
  /// Column, row and layer of each tip, the largest of those that no way leads to included.
  std::vector<std::vector<std::uint32_t>> tips() const {
    std::vector<std::vector<std::uint32_t>> found;
    for (const Strut& strut : supports.list) {
      if (strut.kind == StrutKind::kTip) found.push_back({strut.column0, strut.row0, strut.first});
    }
    for (const UnreachedTips& unreached : {counts.unreached_islands, counts.unreached_overhangs}) {
      const Tip& tip = unreached.largest;
      if (unreached.count > 0) found.push_back({tip.column, tip.row, tip.layer});
    }
    return found;
  }
  bool has_tip_within(const SupportPlace& ball) const {
    return std::ranges::any_of(tips(), [&](const auto& tip) {
      const double x = (tip[0] + 0.5) * 0.1 - ball.x;
      const double y = (tip[1] + 0.5) * 0.1 - ball.y;
      const double z = tip[2] * 0.1 - ball.z;
      return x * x + y * y + z * z <= ball.radius * ball.radius;
    });
  }

  Solid solid;
  ArenaBlock arena;
  SupportCounts counts;
  Supports supports;
  std::vector<Pixels> masks;
};

// Tables: a foot and a plate whose edges hold themselves. Round the high one there is room for pillars.
const std::vector<Block> kTable = {{12, 52, 12, 52, 0, 40}, {3, 56, 3, 61, 20, 40}};
const std::vector<Block> kHighTable = {{44, 84, 44, 84, 0, 48}, {24, 104, 44, 84, 40, 48}};
// A roof on a wall, far enough out for tips.
const std::vector<Block> kRoof = {{0, 10, 0, 64, 0, 40}, {0, 60, 0, 64, 30, 40}};
// A wall, and an island of 1 x 1 mm that joins it higher up.
const std::vector<Block> kIsland = {{0, 10, 20, 44, 0, 48}, {30, 40, 30, 40, 20, 48}, {0, 40, 20, 44, 40, 48}};

TEST(PlacedSupports, AreSetWhereNoneIsNeeded) {
  EXPECT_THAT(Held(kHighTable, on_the_plate(), 128).tips(), IsEmpty());
  // As a finding says it: the middle of a pixel, and the underside of a layer.
  const Held held(kHighTable, on_the_plate({{.x = 2.65, .y = 6.45, .z = 4}}), 128);
  EXPECT_THAT(held.tips(), ElementsAre(ElementsAre(26, 64, 40)));
  EXPECT_EQ(held.counts.added, 1U);
  EXPECT_EQ(held.counts.missed, 0U);
  EXPECT_EQ(held.counts.on_plate, 1U);
  EXPECT_TRUE(held.masks[39].at(26, 64)) << "drawn";
}

TEST(PlacedSupports, AreSetInTheHeightOfARaisedObject) {
  SupportSettings settings = on_the_plate({{.x = 2.65, .y = 6.45, .z = 9.8}});
  settings.object_elevation = 5;
  settings.stand = SupportStand::kRaised;
  const Held held(kHighTable, settings, 128);
  EXPECT_EQ(held.counts.lifted, 58U);
  EXPECT_THAT(held.tips(), ::testing::Contains(ElementsAre(26, 64, 98)));
}

TEST(PlacedSupports, AreSetAtTheLowestSurfaceNearTheirHeight) {
  // Ledges that begin 1.5 and 2.7 mm above the plate.
  const std::vector<Block> ledges = {{10, 60, 0, 64, 0, 48}, {4, 10, 0, 30, 15, 17}, {4, 10, 0, 30, 27, 40}};
  EXPECT_THAT(Held(ledges, on_the_plate({{.x = 0.65, .y = 1.05, .z = 2.7}})).tips(),
              ElementsAre(ElementsAre(6, 10, 15)));
  EXPECT_THAT(Held(ledges, on_the_plate({{.x = 0.65, .y = 1.05, .z = 3.1}})).tips(),
              ElementsAre(ElementsAre(6, 10, 27)));
}

TEST(PlacedSupports, AreSetInTheNearestColumnWithASurface) {
  // 0.4 and 0.6 mm beside the table's edge.
  EXPECT_THAT(Held(kTable, on_the_plate({{.x = 5.95, .y = 3.25, .z = 2}})).tips(),
              ElementsAre(ElementsAre(55, 32, 20)));
  const Held far(kTable, on_the_plate({{.x = 0.55, .y = 3.25, .z = 2}, {.x = 6.15, .y = 3.25, .z = 2}}));
  EXPECT_EQ(far.counts.missed, 2U);
  EXPECT_EQ(far.counts.added, 1U);
}

TEST(PlacedSupports, AreMissedWithoutASurface) {
  // Above the table, in its inside, below its reach, on the plate, beside the panel and nowhere.
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const SupportPlace& place : std::vector<SupportPlace>{{0.5, 3.2, 5.6},
                                                             {3.2, 3.2, 2},
                                                             {0.5, 3.2, 0.4},
                                                             {3.2, 3.2, 0},
                                                             {-3, 3.2, 2},
                                                             {0.5, 900, 2},
                                                             {nan, 3.2, 2},
                                                             {0.5, 3.2, nan}}) {
    const Held held(kTable, on_the_plate({place}));
    EXPECT_EQ(held.counts.missed, 1U) << place.x << ' ' << place.y << ' ' << place.z;
    EXPECT_EQ(held.counts.added, 0U);
    EXPECT_THAT(held.tips(), IsEmpty());
  }
}

TEST(PlacedSupports, TakeThePlaceOfTheTipOfAnIsland) {
  const Held found(kIsland, on_the_plate());
  EXPECT_THAT(found.tips(), ::testing::Contains(ElementsAre(35, 30, 20)));
  const Held held(kIsland, on_the_plate({{.x = 3.85, .y = 3.85, .z = 2}}));
  EXPECT_THAT(held.tips(), ::testing::Contains(ElementsAre(38, 38, 20)));
  EXPECT_EQ(held.counts.islands, found.counts.islands);
  EXPECT_EQ(std::ranges::count(held.tips(), 20U, [](const auto& tip) { return tip[2]; }),
            std::ranges::count(found.tips(), 20U, [](const auto& tip) { return tip[2]; }));
}

TEST(PlacedSupports, HoldASpeckThatWouldBeLeftOut) {
  const std::vector<Block> speck = {{0, 10, 0, 64, 0, 48}, {30, 32, 30, 32, 18, 20}, {0, 40, 0, 64, 20, 48}};
  const Held left_out(speck, on_the_plate());
  EXPECT_EQ(left_out.counts.specks, 1U);
  const Held held(speck, on_the_plate({{.x = 3.05, .y = 3.05, .z = 1.8}}));
  EXPECT_EQ(held.counts.specks, 0U);
  EXPECT_THAT(held.tips(), ::testing::Contains(ElementsAre(30, 30, 18)));
}

TEST(BlockedSupports, LeaveABallFreeAndHoldWhatIsBesideIt) {
  const Held found(kRoof, on_the_plate());
  const SupportPlace ball{.x = 4, .y = 3.2, .z = 3, .radius = 1.2};
  ASSERT_TRUE(found.has_tip_within(ball));
  const Held held(kRoof, on_the_plate({}, {ball}));
  EXPECT_FALSE(held.has_tip_within(ball));
  EXPECT_FALSE(held.tips().empty());
  // A ball that is far below or beside it changes nothing.
  for (const SupportPlace& other : {SupportPlace{4, 3.2, 1.5, 1.2}, SupportPlace{14, 3.2, 3, 1.2}}) {
    EXPECT_EQ(Held(kRoof, on_the_plate({}, {other})).masks, found.masks);
  }
}

TEST(BlockedSupports, LeaveAnIslandToFallAndTheChecksSaySo) {
  const Held held(kIsland, on_the_plate({}, {{.x = 3.5, .y = 3.5, .z = 2, .radius = 2}}));
  EXPECT_FALSE(held.has_tip_within({.x = 3.5, .y = 3.5, .z = 2, .radius = 2}));
  EXPECT_EQ(held.counts.islands, 0U);
  EXPECT_EQ(check(held.masks, {}).count(IssueKind::kFreePiece),
            check(held.solid.masks(), {}).count(IssueKind::kFreePiece));
  EXPECT_EQ(check(held.masks, {}).count(IssueKind::kIsland), 1U);
  EXPECT_EQ(check(Held(kIsland, on_the_plate()).masks, {}).count(IssueKind::kIsland), 0U);
}

TEST(BlockedSupports, AreMovedByAPlaceInTheBall) {
  const SupportPlace ball{.x = 3.5, .y = 3.05, .z = 2, .radius = 2};
  const Held held(kIsland, on_the_plate({{.x = 3.25, .y = 3.75, .z = 2}}, {ball}));
  const auto tips = held.tips();
  EXPECT_THAT(tips, ::testing::Contains(ElementsAre(32, 37, 20)));
  EXPECT_EQ(std::ranges::count(tips, 20U, [](const auto& tip) { return tip[2]; }), 1);
  EXPECT_EQ(check(held.masks, {}).count(IssueKind::kIsland), 0U);
}

TEST(PlacedSupports, AreTheSameForAnyNumberOfThreads) {
  const std::string scan = binary_ply(sphere(6000, 4, {0, 0, 0}));
  SliceSettings settings;
  settings.placement.pixel_pitch_mm = settings.placement.layer_height_mm = 0.1F;
  std::vector<Strut> one;
  for (const std::uint32_t threads : {1U, 3U}) {
    settings.threads = threads;
    Slicing sliced(scan, settings, 64 * kMiB);
    RRep rrep = sliced.rrep();
    // 1 mm beside the lowest point, where the sphere is 0.13 mm higher.
    const double middle_x = sliced.report().printed_mm[0] / 2, middle_y = sliced.report().printed_mm[1] / 2;
    const auto places = on_the_plate({{.x = middle_x + 1, .y = middle_y, .z = 0.1}},
                                     {{.x = middle_x - 1, .y = middle_y, .z = 0.1, .radius = 1}});
    SupportCounts counts;
    const Supports found =
        value_of(find_supports(rrep, places, PrintGrid::kMaxLayers, sliced.arena(), nullptr, counts));
    EXPECT_EQ(counts.added, 1U);
    if (threads == 1) one.assign(found.list.begin(), found.list.end());
    ASSERT_FALSE(one.empty());
    EXPECT_TRUE(std::ranges::equal(found.list, one)) << threads;
  }
}

TEST(PlacedSupports, AreToldOfInTheReport) {
  Solid solid(cubic_grid(kSide, 48), blocks(kTable));
  ArenaBlock arena(32 * kMiB);
  solid.move_to(*arena);
  SliceSettings settings;
  settings.placement.layer_height_mm = 0.1F;
  settings.supports = on_the_plate({{.x = 0.55, .y = 3.25, .z = 2}, {.x = 12.5, .y = -3, .z = 20}});
  SliceReport report;
  SupportCounts counts;
  value_of(add_supports(solid.rrep, settings, *arena, nullptr, report, counts));
  ASSERT_EQ(report.missed_supports.count, 1U);
  EXPECT_EQ(report.missed_supports.list[0], settings.supports->added.list[1]);
}

}  // namespace placed_supports_test
}  // namespace plumbline
