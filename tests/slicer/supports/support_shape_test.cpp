/// Rafts, braces, heads and ways on whole prints, by what a maker would measure on them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "slicer/supports/bracing.hpp"
#include "slicer/supports/obstacles.hpp"
#include "slicer/supports/strut_list.hpp"
#include "slicer/supports/support_finder.hpp"
#include "tests/slicer/checks/checked_stack.hpp"
#include "tests/slicer/support/hanging.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline {
namespace support_shape_test {

using namespace testing;

constexpr double kPitch = 0.1;       ///< mm, of pixels and layers
constexpr std::uint32_t kRaft = 8;   ///< layers
constexpr std::uint32_t kLift = 58;  ///< layers

struct Print {
  Print(std::uint32_t side, std::uint32_t layers, const Inside& inside, const SupportSettings& settings = {})
      : solid(cubic_grid(side, layers), inside), arena(64 * kMiB) {
    solid.move_to(*arena);
    supports = value_of(find_supports(solid.rrep, settings, PrintGrid::kMaxLayers, *arena, nullptr, counts));
    object = solid.masks();
    masks = solid.masks(&supports);
  }
  std::vector<Strut> of(StrutKind kind) const {
    std::vector<Strut> found;
    for (const Strut& strut : supports.list) {
      if (strut.kind == kind) found.push_back(strut);
    }
    return found;
  }
  /// Largest stretch of a pillar, above the raft, at which neither a brace nor a bridge meets it, mm.
  double longest_free() const {
    double longest = 0;
    for (const Strut& pillar : of(StrutKind::kPillar)) {
      std::vector<std::uint32_t> held{std::max<std::uint32_t>(pillar.first, kRaft), pillar.end};
      for (const Strut& strut : supports.list) {
        if (strut.kind != StrutKind::kBrace && strut.kind != StrutKind::kBridge) continue;
        if (strut.column0 == pillar.column0 && strut.row0 == pillar.row0) held.push_back(strut.first);
        if (strut.column1 == pillar.column0 && strut.row1 == pillar.row0) held.push_back(strut.end);
      }
      std::sort(held.begin(), held.end());
      for (std::size_t i = 1; i < held.size(); ++i) longest = std::max(longest, (held[i] - held[i - 1]) * kPitch);
    }
    return longest;
  }

  Solid solid;
  ArenaBlock arena;
  SupportCounts counts;
  Supports supports;
  std::vector<Pixels> object, masks;
};

/// Regions of pixels joined at their sides.
std::uint32_t regions(const Pixels& mask) { return floating_islands({Pixels(mask.columns(), mask.rows()), mask}); }

TEST(SupportShape, PutsOneRaftWithABevelledEdgeBelowALiftedObject) {
  const Print print(260, 100, ball(130, 130, 50, 50));
  EXPECT_EQ(print.counts.lifted, kLift);
  EXPECT_EQ(floating_islands(print.masks), 0U);
  EXPECT_EQ(regions(print.masks[0]), 1U) << "the raft comes off in one piece";
  for (std::uint32_t k = 1; k < kRaft; ++k) {
    for (std::uint32_t r = 0; r < 260; ++r) {
      for (std::uint32_t c = 0; c < 260; ++c) {
        ASSERT_TRUE(print.masks[k].at(c, r) || !print.masks[k - 1].at(c, r)) << "narrower at the top, layer " << k;
      }
    }
    EXPECT_GT(print.masks[k].count(), print.masks[k - 1].count()) << "no bevel at layer " << k;
  }
  EXPECT_LT(print.masks[kRaft].count(), print.masks[kRaft - 1].count()) << "the raft ends";
  for (std::uint32_t k = 0; k < kLift; ++k) EXPECT_EQ(print.object[k].count(), 0U);
}

TEST(SupportShape, HasUprightEdgesIfAsked) {
  SupportSettings settings;
  settings.pad_wall_slope = 90;
  const Print print(260, 100, ball(130, 130, 50, 50), settings);
  EXPECT_EQ(print.masks[0], print.masks[kRaft - 1]);
}

TEST(SupportShape, BracesEveryPillarWithinTenMillimetres) {
  // A board 24 mm above the plate, and a small ball far from it, whose pillar is alone.
  const Inside things = [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return (c >= 60 && c < 160 && r >= 60 && r < 160 && k >= 200 && k < 230) || ball(290, 290, 235, 6)(c, r, k) ||
           ball(110, 110, 3, 3)(c, r, k);
  };
  const Print print(360, 250, things);
  EXPECT_EQ(floating_islands(print.masks), 0U);
  EXPECT_GT(print.counts.braces, 4U);
  EXPECT_GE(print.counts.helpers, 1U);
  EXPECT_EQ(print.counts.unbraced, 0U);
  EXPECT_GT(print.longest_free(), 1);
  EXPECT_LE(print.longest_free(), Bracing::kMostFree_mm + 6 * kPitch);
  EXPECT_LE(print.counts.longest_free_mm, Bracing::kMostFree_mm);
  SupportSettings none;
  none.max_pillar_link_distance = 0;
  const Print alone(360, 250, things, none);
  EXPECT_EQ(alone.counts.braces, 0U);
  EXPECT_GT(alone.counts.unbraced, 0U) << "the check sees no free pillar";
}

TEST(SupportShape, PropsALonePillarByLegsOnItsOwnBase) {
  // A ball of 1.6 mm, 15 mm above the raft.
  SupportSettings settings;
  settings.object_elevation = 15;
  const Print print(120, 20, ball(60, 60, 8, 8), settings);
  EXPECT_EQ(floating_islands(print.masks), 0U);
  EXPECT_EQ(print.counts.helpers, 0U);
  EXPECT_LE(print.counts.longest_free_mm, Bracing::kWantedFree_mm + 4 * kPitch);
  std::uint32_t legs = 0;
  for (const Strut& brace : print.of(StrutKind::kBrace)) {
    if (brace.first != kRaft) continue;
    EXPECT_TRUE(print.masks[kRaft - 1].at(brace.column0, brace.row0)) << "it stands on the raft";
    ++legs;
  }
  EXPECT_GT(legs, 0U);
}

/// Braces of pillars that stand 5 mm from the panel's left edge, without an object.
struct Braced {
  struct Upright {
    double x, top;  ///< mm
  };
  Braced(std::size_t most_struts, const std::vector<Upright>& uprights) : struts(most_struts) {
    const Obstacles obstacles = value_of(Obstacles::create(nothing.rrep, nanometres(1.5), *arena));
    StrutList list(nothing.rrep.grid, struts, pillars);
    for (const Upright& upright : uprights) {
      Pillar pillar;
      pillar.x = upright.x;
      pillar.y = 5;
      pillar.top = upright.top;
      pillar.radius = 0.5;
      pillar.on_plate = true;
      EXPECT_TRUE(list.add_pillar(pillar));
    }
    Bracing bracing({}, 0.8, obstacles, list, contacts);
    EXPECT_TRUE(bracing.brace_all());
    counts = bracing.counts();
    spare = list.spare();
    struts.resize(list.struts().size());
  }

  Solid nothing{cubic_grid(120, 400), [](auto, auto, auto) { return false; }};
  ArenaBlock arena{16 * kMiB};
  std::vector<Strut> struts;
  std::vector<Pillar> pillars{8};
  std::vector<StrutContact> contacts{64};
  BraceCounts counts;
  std::size_t spare = 0;
};

TEST(SupportShape, LeavesTheRaftItsStrutsWhenBracesFillTheList) {
  const Braced two(10, {{4, 38}, {7, 38}});
  EXPECT_GT(two.counts.braces, 2U);
  EXPECT_GE(two.spare, 4U) << "two discs and two bars";
  EXPECT_EQ(two.counts.unbraced, 2U);
}

TEST(SupportShape, PropsAPillarFromOneThatIsLower) {
  const Braced two(200, {{4, 13}, {7, 8}});
  EXPECT_EQ(two.counts.helpers, 0U);
  EXPECT_LE(two.counts.longest_free_mm, Bracing::kWantedFree_mm);
  for (const Strut& brace : two.struts) {
    if (brace.column0 != 70 || brace.column1 != 40) continue;
    EXPECT_LE(brace.first, 80) << "it begins at the lower pillar";
    EXPECT_LE(brace.end, 130);
  }
}

TEST(SupportShape, PutsNoBracesBetweenPillarsThatNearlyTouch) {
  for (const double beside : {4.3, 5.3}) {
    const Braced three(200, {{4, 10}, {beside, 10}, {8, 10}});
    EXPECT_GT(three.counts.braces, 1U);
    EXPECT_LE(three.counts.longest_free_mm, Bracing::kWantedFree_mm);
    for (const Strut& brace : three.struts) {
      EXPECT_NE(brace.column0 + brace.column1, std::lround(40 + 10 * beside));
    }
  }
}

TEST(SupportShape, HoldsASixteenthOfAnIslandsFirstLayer) {
  // A block, and beside it one of 4.4 mm2 that begins in the air.
  const Print print(120, 60, blocks({{20, 60, 20, 60, 0, 60}, {80, 101, 20, 41, 30, 60}, {60, 80, 28, 32, 50, 60}}));
  EXPECT_GE(print.counts.islands + print.counts.overhangs, 3U);
  EXPECT_EQ(check(print.masks, {}, static_cast<float>(kPitch)).count(IssueKind::kIsland), 0U);
}

TEST(SupportShape, HoldsAnIslandThatWidensByMoreTips) {
  // Beside a block a disc of 2.8 mm diameter, all of which a tip in its middle reaches, below it a stem of 0.4 mm.
  const Inside stem = blocks({{10, 50, 20, 60, 0, 60}, {84, 88, 38, 42, 20, 21}});
  const Print print(140, 60, [&](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return stem(c, r, k) || (k > 20 && (c - 86.0) * (c - 86.0) + (r - 40.0) * (r - 40.0) <= 14 * 14);
  });
  EXPECT_GE(print.counts.all(), 4U);
  EXPECT_LT(print.counts.largest_load_mm2, 2.8);
}

TEST(SupportShape, PointsHeadsAlongTheSurfacesNormal) {
  // A slab at 40 degrees from the plate, rising to the right.
  const Inside slab = [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const double up = k - 0.839 * (c - 100.0);
    return c >= 100 && c < 200 && r >= 100 && r < 160 && up >= 20 && up < 50;
  };
  SupportSettings settings;
  settings.overhang_angle = 45;
  settings.area_per_tip = 4;
  const Print print(300, 140, slab, settings);
  int along = 0;
  int all = 0;
  for (const Strut& head : print.of(StrutKind::kHead)) {
    if (head.column1 < 115 || head.column1 > 185 || head.row1 < 115 || head.row1 > 145) continue;  // edges
    ++all;
    const double dx = head.column0 - head.column1;
    const double dz = head.end - head.first;
    // The outward normal of the underside leans to the right by 40 degrees: tan = 0.839.
    along += std::abs(dx / dz - 0.839) < 0.25 && std::abs(head.row0 - head.row1) <= 2 ? 1 : 0;
  }
  EXPECT_GE(all, 4);
  EXPECT_EQ(along, all);
}

TEST(SupportShape, KeepsPillarsAMillimetreFromWallsAndLeadsThemToThePlate) {
  // A board above a table of the same size: nothing below the board is free, the plate beside the table is.
  const Inside table =
      blocks({{100, 150, 100, 150, 0, 40}, {120, 130, 120, 130, 40, 90}, {100, 150, 100, 150, 90, 100}});
  const Print print(260, 100, table);
  EXPECT_EQ(print.counts.lifted, 0U);
  EXPECT_EQ(floating_islands(print.masks), 0U);
  EXPECT_EQ(print.counts.unreached(), 0U);
  std::uint32_t measured = 0;
  for (const Strut& strut : print.of(StrutKind::kPillar)) {
    if (strut.first > 0) continue;
    for (std::uint32_t k = 0; k + 20 < strut.end; ++k) {  // a pillar's upper end is near its tip
      for (int dy = -13; dy <= 13; ++dy) {
        for (int dx = -13; dx <= 13; ++dx) {
          if (dx * dx + dy * dy > 13 * 13) continue;
          ASSERT_FALSE(print.object[k].at(strut.column0 + dx, strut.row0 + dy)) << "near a wall in layer " << k;
        }
      }
      ++measured;
    }
  }
  EXPECT_GT(measured, 0U);
}

/// A drop in a shaft 2.6 mm wide and 8 mm deep, 1.1 mm from its left wall: every pillar would stand nearer than a millimetre to the walls.
/// @param wall  thickness of the shaft's walls, pixels
Inside drop_in_shaft(std::uint32_t wall) {
  return [wall](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const bool shaft = c >= 49 && c < 75 && r >= 47 && r < 73;
    const bool block = c >= 49 - wall && c < 75 + wall && r >= 47 - wall && r < 73 + wall && (!shaft || k < 10);
    return (block && k < 100) || ball(60, 60, 94, 5)(c, r, k);
  };
}

TEST(SupportShape, LeansAPinOnTheNearestWallWhereNoPillarStands) {
  const Print print(130, 110, drop_in_shaft(22));
  EXPECT_EQ(print.counts.on_object, 1U);
  EXPECT_EQ(print.counts.unreached(), 0U);
  EXPECT_EQ(floating_islands(print.masks), 0U);
  ASSERT_EQ(print.of(StrutKind::kBase).size(), 1U);
  const Strut end = print.of(StrutKind::kBase)[0];
  const Strut tip = print.of(StrutKind::kTip)[0];
  EXPECT_LT(end.column0, 49 - 1) << "in the left wall, which is the nearest";
  EXPECT_GT(end.column0, 49 - 8);
  EXPECT_NEAR(tip.column0 - end.column0, tip.first - end.first, 2) << "at 45 degrees";
  // By what the wall and the drop are: clear of both but within 0.75 mm of the pin's ends.
  const std::uint32_t foot = tip.first - (tip.column0 - 49U);
  std::uint32_t measured = 0;
  for (const Strut& strut : print.supports.list) {
    for (std::uint32_t k = std::max<std::uint32_t>(strut.first, foot + 1); k < std::min(strut.end, tip.first); ++k) {
      const StrutSection disc = section_of(strut, k);
      ASSERT_FALSE(print.object[k].at(disc.column, disc.row)) << "through the object in layer " << k;
      const double way = std::min(k + 0.5 - foot, tip.first - k - 0.5) * kPitch * std::sqrt(2.0);
      if (way < 0.75) continue;
      const auto reach = static_cast<int>((static_cast<double>(disc.radius) / 1e6 + way / 2 - 0.25) / kPitch);
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          if (dx * dx + dy * dy > reach * reach) continue;
          ASSERT_FALSE(print.object[k].at(disc.column + static_cast<std::uint32_t>(dx),
                                          disc.row + static_cast<std::uint32_t>(dy)))
              << "near a wall in layer " << k;
        }
      }
      ++measured;
    }
  }
  EXPECT_GT(measured, 0U);
  const Print again(130, 110, drop_in_shaft(22));
  EXPECT_TRUE(std::ranges::equal(print.supports.list, again.supports.list));
}

TEST(SupportShape, GivesNoSupportToWhatItCantReach) {
  SupportSettings plate_only;
  plate_only.buildplate_only = true;
  // Walls of 0.3 mm hold no foot: a pin would come out at their other side.
  for (const Print& print : {Print(130, 110, drop_in_shaft(22), plate_only), Print(130, 110, drop_in_shaft(3))}) {
    EXPECT_EQ(print.counts.all(), 0U);
    EXPECT_EQ(print.counts.unreached(), 1U);
    EXPECT_EQ(floating_islands(print.masks), 1U);
    EXPECT_TRUE(print.supports.empty());
  }
}

TEST(SupportShape, LeavesACutterRoomBetweenPillarsAndBetweenBraces) {
  // A board 24 mm above the plate.
  const Print print(360, 250, blocks({{60, 260, 60, 260, 200, 230}, {150, 170, 150, 170, 0, 200}}));
  const auto pillars = print.of(StrutKind::kPillar);
  ASSERT_GT(pillars.size(), 4U);
  std::uint32_t joined = 0;
  for (const Strut& a : pillars) {
    for (const Strut& b : pillars) {
      if (&a == &b) continue;
      const double apart =
          std::hypot(a.column0 - b.column0, a.row0 - b.row0) * kPitch - (a.radius0 + b.radius0) / 1000.0;
      EXPECT_GT(apart, 1 - kPitch);
    }
    std::vector<double> braces;
    for (const Strut& brace : print.of(StrutKind::kBrace)) {
      if (brace.column0 == a.column0 && brace.row0 == a.row0) braces.push_back(brace.first * kPitch);
    }
    joined += braces.empty() ? 0 : 1;
  }
  EXPECT_GT(joined, 0U);
}

TEST(SupportShape, LimitsTheAreaThatATipCarries) {
  // A disc 16 mm wide on a thin stem.
  const Inside mushroom = [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const double dx = c + 0.5 - 130;
    const double dy = r + 0.5 - 130;
    return dx * dx + dy * dy < (k < 40 ? 30 * 30 : 80 * 80);
  };
  std::uint32_t before = 0;
  for (const double limit : {12.0, 4.0, 2.0}) {
    SupportSettings settings;
    settings.area_per_tip = limit;
    const Print print(260, 60, mushroom, settings);
    EXPECT_GT(print.counts.all(), before);
    before = print.counts.all();
    // By the definition: each pixel of the disc's underside farther from the stem than a tip reaches belongs to its nearest tip.
    const auto tips = print.of(StrutKind::kTip);
    std::vector<double> load(tips.size());
    for (std::uint32_t r = 0; r < 260; ++r) {
      for (std::uint32_t c = 0; c < 260; ++c) {
        const double from_stem = std::hypot(c + 0.5 - 130, r + 0.5 - 130) - 30;
        if (!print.object[40].at(c, r) || from_stem * kPitch < 1.5) continue;
        std::size_t nearest = 0;
        double least = 1e9;
        for (std::size_t i = 0; i < tips.size(); ++i) {
          const double dx = tips[i].column0 - static_cast<double>(c);
          const double dy = tips[i].row0 - static_cast<double>(r);
          if (dx * dx + dy * dy < least) {
            least = dx * dx + dy * dy;
            nearest = i;
          }
        }
        load[nearest] += kPitch * kPitch;
      }
    }
    EXPECT_LE(*std::max_element(load.begin(), load.end()), limit + 0.5);
    EXPECT_GT(print.counts.heavy + print.counts.medium, 0U);
    // Where tips at their least distance can't relieve each other, the limit gives way.
    if (limit >= 4) {
      EXPECT_LE(print.counts.largest_load_mm2, limit + 0.1);
    }
  }
}

TEST(SupportShape, HoldsItsTipsOnCoarsePixelsToo) {
  for (const float pitch : {0.2F, 0.3F}) {
    Solid solid(cubic_grid(110, 70, pitch), ball(55, 55, 36, 33));
    ArenaBlock arena(64 * kMiB);
    solid.move_to(*arena);
    SupportCounts counts;
    const Supports supports = value_of(find_supports(solid.rrep, {}, PrintGrid::kMaxLayers, *arena, nullptr, counts));
    EXPECT_GT(counts.all(), 0U);
    EXPECT_EQ(floating_islands(solid.masks(&supports)), 0U) << pitch;
  }
}

TEST(SupportShape, LeavesNoIslandFromATenthToTenTimesTheSize) {
  // A ball of 5 mm with an arm that leans by 40 degrees and a drop below its end, and its print ten times smaller and larger.
  struct Size {
    double scale;
    float pitch;
  };
  for (const Size& size : {Size{0.1, 0.02F}, Size{0.3, 0.05F}, Size{1, 0.1F}, Size{3, 0.2F}, Size{10, 0.4F}}) {
    const double mm = static_cast<double>(size.pitch) / size.scale;  // of a pixel, in the unscaled object
    const auto side = static_cast<std::uint32_t>(std::ceil(16 / mm));
    const auto layers = static_cast<std::uint32_t>(std::ceil(7 / mm));
    const Inside shape = [mm](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
      const double x = (c + 0.5) * mm - 5;
      const double y = (r + 0.5) * mm - 8;
      const double z = (k + 0.5) * mm;
      const auto ball_at = [&](double bx, double bz, double radius) {
        return (x - bx) * (x - bx) + y * y + (z - bz) * (z - bz) < radius * radius;
      };
      const double arm = z - 2.5 - 0.6 * x;
      return ball_at(0, 2.5, 2.5) || ball_at(5, 3.5, 1) || (x > 0 && x < 6 && std::abs(y) < 0.7 && std::abs(arm) < 0.6);
    };
    Solid solid(cubic_grid(side, layers, size.pitch), shape);
    ArenaBlock arena(64 * kMiB);
    solid.move_to(*arena);
    SupportCounts counts;
    const std::size_t before = arena->used();
    arena->reset_peak();
    const std::size_t planned = find_supports_bytes(solid.rrep, {});
    const Supports supports = value_of(find_supports(solid.rrep, {}, PrintGrid::kMaxLayers, *arena, nullptr, counts));
    EXPECT_LE(arena->peak() - before, planned) << size.scale;
    EXPECT_EQ(floating_islands(solid.masks(&supports)), 0U) << size.scale;
    EXPECT_EQ(counts.unbraced, 0U) << size.scale;
    EXPECT_GT(counts.all(), 0U) << size.scale;
  }
}

TEST(SupportShape, IsNeverCutAtThePanelsEdge) {
  // A ball that nearly touches the edges.
  const Print print(110, 100, ball(55, 55, 50, 50));
  EXPECT_EQ(floating_islands(print.masks), 0U);
  for (const Strut& strut : print.of(StrutKind::kRaft)) {
    for (std::uint32_t k = strut.first; k < strut.end; ++k) {
      const auto reach = static_cast<int>(section_of(strut, k).radius / 100'000);
      EXPECT_GE(strut.column0 - reach, 0);
      EXPECT_LT(strut.column0 + reach, 110);
      EXPECT_GE(strut.row0 - reach, 0);
      EXPECT_LT(strut.row0 + reach, 110);
    }
  }
}

}  // namespace support_shape_test
}  // namespace plumbline
