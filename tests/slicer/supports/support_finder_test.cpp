#include "slicer/supports/support_finder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "slicer/supports/tips.hpp"
#include "tests/slicer/checks/checked_stack.hpp"
#include "tests/slicer/support/hanging.hpp"
#include "tests/slicer/support/solid.hpp"
#include "tests/slicer/support/stop.hpp"

namespace plumbline {
namespace support_finder_test {

using namespace testing;
using ::testing::HasSubstr;

// With the default settings, in pixels of 0.1 mm.
constexpr double kReach = 19.5;   ///< of a tip: sqrt(support_area_per_tip / pi)
constexpr double kRounded = 6;    ///< the growth lags by up to 4 pixels; the rest is rounding
constexpr double kGrowth = 1.43;  ///< of held area in a layer: 1 / tan(support_overhang_angle)
constexpr std::uint32_t kSide = 64;

/// On the plate as it is.
SupportSettings on_the_plate() {
  SupportSettings settings;
  settings.object_elevation = 0;
  return settings;
}

/// A solid with the supports found for it.
struct Supported {
  Supported(const PrintGrid& grid, const Inside& inside, const SupportSettings& settings = on_the_plate())
      : solid(grid, inside), arena(32 * kMiB) {
    solid.move_to(*arena);
    supports = value_of(find_supports(solid.rrep, settings, PrintGrid::kMaxLayers, *arena, nullptr, counts));
    object = solid.masks();
    masks = solid.masks(&supports);
  }
  explicit Supported(const Inside& inside, const SupportSettings& settings = on_the_plate())
      : Supported(cubic_grid(kSide, 48), inside, settings) {}

  double hang(double growth = kGrowth) const { return farthest_hang(object, supports.list, growth, 30); }
  std::vector<Strut> tips() const {
    std::vector<Strut> found;
    for (const Strut& strut : supports.list) {
      if (strut.kind == StrutKind::kTip) found.push_back(strut);
    }
    return found;
  }

  Solid solid;
  ArenaBlock arena;
  SupportCounts counts;
  Supports supports;
  std::vector<Pixels> object;  ///< masks without supports
  std::vector<Pixels> masks;   ///< with them
};

/// Checks what holds for every object: nothing floats but what no support reaches; each tip is at the object, no strut passes through it, and each is there in
/// all of its layers; no pixel of the object is lost.
void expect_printable(const Supported& s) {
  EXPECT_LE(floating_islands(s.masks), 2 * s.counts.unreached());
  for (const Strut& strut : s.supports.list) {
    if (strut.kind == StrutKind::kTip) {
      EXPECT_TRUE(s.object[strut.first].at(strut.column0, strut.row0));
      continue;
    }
    for (std::uint32_t k = strut.first; k < strut.end; ++k) {
      const StrutSection disc = section_of(strut, k);
      EXPECT_TRUE(s.masks[k].at(disc.column, disc.row)) << "broken in layer " << k;
      // A pad, or a foot in the object, upright or in a wall.
      const bool leans = strut.column0 != strut.column1 || strut.row0 != strut.row1;
      if (strut.kind == StrutKind::kBase && (leans || strut.radius0 == strut.radius1)) continue;
      // A slanted head meets the surface at its side.
      if (strut.kind == StrutKind::kHead && k + 2 >= strut.end) continue;
      EXPECT_FALSE(s.object[k].at(disc.column, disc.row))
          << "through the object in layer " << k << ", kind " << static_cast<int>(strut.kind);
    }
  }
  for (std::size_t k = 0; k < s.masks.size(); ++k) {
    for (std::uint32_t r = 0; r < s.masks[k].rows(); ++r) {
      for (std::uint32_t c = 0; c < s.masks[k].columns(); ++c) {
        ASSERT_TRUE(s.masks[k].at(c, r) || !s.object[k].at(c, r)) << "pixel lost in layer " << k;
      }
    }
  }
  EXPECT_EQ(s.counts.all(), s.supports.tips());
  EXPECT_EQ(s.counts.islands + s.counts.overhangs, s.counts.all() + s.counts.unreached());
  EXPECT_EQ(s.counts.light + s.counts.medium + s.counts.heavy, s.counts.all());
  if (s.counts.unreached() == 0) {
    EXPECT_LE(s.hang(), kReach + kRounded);
  }
}

/// Upright, its apex at the bottom.
Inside cone(double apex, double slope) {
  return [=](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const double radius = (k + 0.5 - apex) * slope;
    const double dx = c + 0.5 - kSide / 2.0;
    const double dy = r + 0.5 - kSide / 2.0;
    return radius > 0 && dx * dx + dy * dy < radius * radius;
  };
}

TEST(Supports, AreNoneBelowACubeOnThePlate) {
  const Supported s(blocks({{20, 44, 20, 44, 0, 40}}));
  EXPECT_TRUE(s.supports.empty());
  EXPECT_EQ(s.masks, s.object);
}

TEST(Supports, AreNoneInAnEmptyPrint) {
  const Supported s(blocks({}));
  EXPECT_TRUE(s.supports.empty());
}

TEST(Supports, PutPadsBelowSmallFeetOnThePlate) {
  // Two feet of 0.36 and 0.25 mm2 side by side, and one of 1 mm2.
  const Supported s(blocks({{20, 26, 20, 26, 0, 40}, {20, 25, 27, 32, 0, 40}, {45, 55, 20, 30, 0, 40}}));
  EXPECT_EQ(s.counts.pads, 1U) << "a foot on another one's pad needs none";
  EXPECT_EQ(s.supports.tips(), 0U);
  // A disc of 1 mm, 0.3 mm high, round the first one.
  for (std::uint32_t k = 0; k < 5; ++k) {
    EXPECT_EQ(s.masks[k].at(14, 20), k < 3) << k;
    EXPECT_EQ(s.masks[k].at(32, 20), k < 3) << k;
  }
  EXPECT_NEAR(static_cast<double>(s.masks[0].count()), 314 + 100, 16);
  EXPECT_EQ(s.masks[3], s.object[3]);
}

TEST(Supports, PutNoPadsBelowARaft) {
  const Supported s(cone(8, 0.8), SupportSettings{});
  EXPECT_GT(s.counts.lifted, 0U);
  EXPECT_EQ(s.counts.pads, 0U);
}

TEST(Supports, HoldASpeckThatOnlyAThickerTipWouldTouch) {
  // A light tip has a radius of 12 pixels of 0.0125 mm, a medium one of 16. From the tip at (32, 31), the speck is 11 aside and 7 up.
  const Supported s(cubic_grid(kSide, 48, 0.0125F), blocks({{31, 34, 31, 34, 20, 44}, {43, 46, 38, 41, 21, 44}}));
  EXPECT_EQ(floating_islands(s.masks), 0U);
  EXPECT_EQ(s.counts.islands, 2U);
}

TEST(Supports, HoldABlobThatHangsOnAFewPixels) {
  // 9 of 100 pixels continue from below. Nothing is farther than 1 mm from these, so it is no overhang.
  const Inside blob = blocks({{5, 25, 5, 25, 0, 40}, {40, 43, 40, 43, 0, 40}, {37, 47, 37, 47, 30, 40}});
  const Supported s(cubic_grid(2 * kSide, 48), blob);
  expect_printable(s);
  ASSERT_EQ(s.tips().size(), 1U);
  EXPECT_EQ(s.counts.islands, 1U);
  EXPECT_EQ(s.tips()[0].first, 30U);
  EXPECT_EQ(check(s.object, {}).count(IssueKind::kIsland), 1U);
  EXPECT_EQ(check(s.masks, {}).count(IssueKind::kIsland), 0U);
  // 25 pixels of 80 hold.
  const Supported held(blocks({{5, 25, 5, 25, 0, 40}, {40, 45, 40, 45, 0, 40}, {40, 48, 40, 50, 20, 30}}));
  EXPECT_EQ(held.tips().size(), 0U);
}

/// A roof that a wall holds, and under it an icicle above other blocks.
Supported cave_above(const std::vector<Block>& others) {
  std::vector<Block> all = {
      {2, 62, 2, 62, 0, 10}, {2, 8, 2, 62, 10, 100}, {2, 62, 2, 62, 90, 100}, {30, 35, 30, 35, 80, 90}};
  all.insert(all.end(), others.begin(), others.end());
  return Supported(cubic_grid(kSide, 100), blocks(all));
}

/// Whether each foot on the object rests on it with at least half of a tip's area.
bool feet_rest(const Supported& s) {
  return std::ranges::all_of(s.supports.list, [&](const Strut& foot) {
    if (foot.kind != StrutKind::kBase || foot.first == 0 || foot.radius0 == foot.radius1) return true;
    int pixels = 0;
    int resting = 0;
    for (int y = -2; y <= 2; ++y) {
      for (int x = -2; x <= 2; ++x) {
        if (x * x + y * y > 4) continue;
        ++pixels;
        for (std::uint32_t k = foot.first - 3; k <= foot.first; ++k) {
          if (!s.object[k].at(foot.column0 + x, foot.row0 + y)) continue;
          ++resting;
          break;
        }
      }
    }
    return 2 * resting >= pixels;
  });
}

TEST(Supports, StandInTheObjectAndNotOnThePointOfASpire) {
  // The spire's point has 9 pixels, a foot there 13.
  const Supported s = cave_above({{24, 41, 24, 41, 10, 35}, {31, 34, 29, 32, 35, 40}});
  EXPECT_GE(s.counts.on_object, 1U);
  EXPECT_TRUE(feet_rest(s));
  EXPECT_EQ(floating_islands(s.masks), 0U);
  EXPECT_EQ(check(s.masks, {}).count(IssueKind::kIsland), 0U);
}

TEST(Supports, StandBesideTheEdgeOfAThinWallAndNotOnIt) {
  // A foot on the edge of a wall of 2 x 12 pixels would be torn off.
  const Supported s = cave_above({{31, 33, 26, 38, 10, 40}});
  EXPECT_GE(s.counts.on_object, 1U);
  EXPECT_TRUE(feet_rest(s));
  EXPECT_EQ(floating_islands(s.masks), 0U);
  EXPECT_EQ(check(s.masks, {}).count(IssueKind::kTear), 0U);
}

TEST(Supports, HoldTheWingsOfAT) {
  const Supported s(blocks({{31, 33, 20, 44, 0, 40}, {2, 62, 20, 44, 24, 40}}));
  expect_printable(s);
  EXPECT_EQ(s.counts.islands, 0U);
  EXPECT_EQ(s.counts.on_object, 0U);
  EXPECT_GE(s.counts.overhangs, 2U);
  EXPECT_LE(s.counts.overhangs, 16U);  // each wing is 29 x 24 pixels; the stem holds 26 of the 29
  for (const Strut& tip : s.tips()) EXPECT_EQ(tip.first, 24);
  EXPECT_GT(farthest_hang(s.object, {}, 1, 30), kReach + kRounded) << "the check sees no wings";
}

TEST(Supports, HoldAToothThatHangsInAnArch) {
  const Inside arch =
      blocks({{4, 14, 20, 44, 0, 48}, {50, 60, 20, 44, 0, 48}, {4, 60, 20, 44, 40, 48}, {30, 34, 30, 34, 12, 40}});
  const Supported s(arch);
  expect_printable(s);
  EXPECT_EQ(s.counts.islands, 1U);
  EXPECT_EQ(floating_islands(s.object), 1U) << "the check sees no tooth";
  const auto tips = s.tips();
  const auto tooth = std::find_if(tips.begin(), tips.end(), [](const Strut& x) { return x.first == 12; });
  ASSERT_NE(tooth, tips.end());
  EXPECT_NEAR(tooth->column0, 32, 2);
  EXPECT_NEAR(tooth->row0, 32, 2);
}

TEST(Supports, HoldAConeOnlyAtItsTip) {
  const Supported s(cone(8, 0.8));  // steeper than the critical angle
  expect_printable(s);
  ASSERT_EQ(s.tips().size(), 1U);
  EXPECT_EQ(s.counts.islands, 1U);
  EXPECT_NEAR(s.tips()[0].column0, 32, 1);
  EXPECT_NEAR(s.tips()[0].row0, 32, 1);
}

TEST(Supports, HoldAFlatConeAllAround) {
  const Supported s(cone(8, 2.2));
  expect_printable(s);
  EXPECT_EQ(s.counts.islands, 1U);
  EXPECT_GE(s.counts.overhangs, 4U);
  for (const bool right : {false, true}) {
    for (const bool back : {false, true}) {
      const auto tips = s.tips();
      EXPECT_TRUE(std::any_of(
          tips.begin(), tips.end(),
          [&](const Strut& x) { return (x.column0 >= kSide / 2) == right && (x.row0 >= kSide / 2) == back; }))
          << "quarter " << right << back;
    }
  }
}

TEST(Supports, HoldASphereWhereItIsFlat) {
  const Supported s(ball(32, 32, 24, 24));
  expect_printable(s);
  EXPECT_EQ(floating_islands(s.object), 0U);
  // The lower 45 degrees of it are flatter than the critical angle.
  for (const Strut& tip : s.tips()) EXPECT_LT(tip.first, 24 - 24 * 0.6);
}

TEST(Supports, HoldASphereAboveThePlate) {
  const Supported s(ball(32, 32, 27, 20));
  expect_printable(s);
  EXPECT_GE(s.counts.islands, 1U);
  EXPECT_EQ(s.counts.on_object, 0U);
}

TEST(Supports, LeaveShortBridgesFree) {
  const auto bridge = [](std::uint32_t gap) {
    return blocks({{0, 32 - gap / 2, 4, 60, 0, 40}, {32 + gap / 2, 64, 4, 60, 0, 40}, {0, 64, 4, 60, 24, 40}});
  };
  const Supported shorter(bridge(28));
  EXPECT_TRUE(shorter.supports.empty());
  const Supported longer(bridge(58));
  expect_printable(longer);
  EXPECT_FALSE(longer.supports.empty());
  SupportSettings settings = on_the_plate();
  settings.overhang_span = 8;
  settings.area_per_tip = 60;
  EXPECT_TRUE(Supported(bridge(58), settings).supports.empty());
}

TEST(Supports, EndOnTheObjectWhereItIsBelow) {
  // A wall with a board at its foot and another near its top.
  const Supported s(blocks({{0, 6, 20, 44, 0, 48}, {0, 50, 20, 44, 0, 8}, {0, 50, 20, 44, 36, 44}}));
  expect_printable(s);
  EXPECT_EQ(s.counts.on_plate, 0U);
  EXPECT_GT(s.counts.on_object, 0U);
  for (const Strut& strut : s.supports.list) {
    const bool at_foot = strut.kind == StrutKind::kBase;
    const bool at_tip = strut.kind == StrutKind::kTip;
    EXPECT_TRUE(!at_foot || strut.first == 8 || strut.end == 8);  // on the object, or in it
    EXPECT_TRUE(!at_tip || strut.first == 36);
  }
}

TEST(Supports, AreAbsentBelowSlopesSteeperThanTheCriticalAngle) {
  // A wall at 30 degrees to the plate: 1.7 pixels out for each layer up.
  const Inside leaning = [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return r >= 20 && r < 44 && c >= 17 * k / 10 && c < 17 * k / 10 + 12;
  };
  SupportSettings settings = on_the_plate();
  settings.overhang_angle = 25;
  const PrintGrid grid = cubic_grid(96, 45);
  EXPECT_TRUE(Supported(grid, leaning, settings).supports.empty());
  const Supported s(grid, leaning);
  expect_printable(s);
  EXPECT_FALSE(s.supports.empty());
}

TEST(Supports, EndWithTheObjectAboveThem) {
  // A sheet one layer thick: a head that reached 0.2 mm into it would stick out at the top.
  const Supported s(blocks({{0, 6, 20, 44, 0, 30}, {0, 50, 20, 44, 20, 21}}));
  expect_printable(s);
  ASSERT_FALSE(s.supports.empty());
  for (const Strut& tip : s.tips()) EXPECT_EQ(tip.end, 21);
}

TEST(Supports, HoldRandomObjects) {
  Random random(7);
  for (int i = 0; i < 10; ++i) {
    std::vector<Block> all;
    for (int b = 0; b < 12; ++b) {
      const std::uint32_t c = random.below(56);
      const std::uint32_t r = random.below(56);
      const std::uint32_t k = random.below(28);
      all.push_back({c, c + 2 + random.below(20), r, r + 2 + random.below(20), k, k + 1 + random.below(10)});
    }
    const Supported s(cubic_grid(kSide, 32), blocks(all));
    EXPECT_GT(floating_islands(s.object), 0U);
    expect_printable(s);
  }
}

/// On the plate, a wall with a slab from layer 20 on, which bridges less than needs a tip, and below the slab whatever `below` is.
Inside slab_over(const Block& below) { return blocks({{20, 30, 10, 54, 0, 40}, {30, 42, 10, 54, 20, 40}, below}); }

TEST(Supports, LeaveOutASpeckThatATipWouldCover) {
  // A light tip has 7 pixels and reaches 2 layers into the object.
  const Supported s(slab_over({36, 39, 30, 32, 18, 20}));
  EXPECT_EQ(s.counts.specks, 1U);
  EXPECT_NEAR(s.counts.specks_mm3, 2 * 0.06 * 0.1, 1e-6);
  EXPECT_TRUE(s.supports.empty());
  const Solid without(cubic_grid(kSide, 48), slab_over({0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(s.masks, without.masks()) << "the slab stays as it is";
  EXPECT_FALSE(s.counts.lost_pixels) << "opening and closing may take more than the speck";
}

TEST(Supports, LeaveOutASpeckBelowALiftedObject) {
  // A slab on a neck; without a lift it would stand on the plate.
  const Inside shape = blocks({{10, 54, 10, 54, 12, 40}, {31, 33, 31, 33, 11, 12}});
  SupportSettings settings;
  settings.object_elevation = 2;
  const Supported s(cubic_grid(kSide, 48), shape, settings);
  EXPECT_GT(s.counts.lifted, 0U);
  EXPECT_EQ(s.counts.specks, 1U);
  EXPECT_EQ(floating_islands(s.masks), 0U);
  EXPECT_EQ(s.object[11 + s.counts.lifted].count(), 0U);
  EXPECT_EQ(s.object[12 + s.counts.lifted].count(), 44U * 44U);
}

TEST(Supports, HoldAFlatUndersideThatIsRaised) {
  SupportSettings settings;
  EXPECT_TRUE(Supported(blocks({{10, 54, 10, 54, 0, 40}}), settings).supports.empty());
  settings.stand = SupportStand::kRaised;
  settings.object_elevation = 4;
  settings.base_diameter = 1;
  for (const double raft_mm : {0.8, 0.0}) {
    settings.pad_wall_thickness = raft_mm;
    const Supported s(blocks({{10, 54, 10, 54, 0, 40}}), settings);
    EXPECT_EQ(s.counts.lifted, raft_mm > 0 ? 48U : 40U);
    EXPECT_EQ(s.counts.unreached(), 0U);
    EXPECT_EQ(floating_islands(s.masks), 0U);
    EXPECT_LE(s.hang(), kReach + kRounded);
    const auto is_raft = [](const Strut& strut) { return strut.kind == StrutKind::kRaft; };
    EXPECT_EQ(std::ranges::any_of(s.supports.list, is_raft), raft_mm > 0);
  }
}

TEST(Supports, AreAsManyAsTheDensitySays) {
  // The raised underside of a block 20 mm square, in pixels of 0.2 mm.
  const auto at = [](double percent) {
    SupportSettings settings;
    settings.stand = SupportStand::kRaised;
    settings.points_density_relative = percent;
    return Supported(cubic_grid(110, 10, 0.2F), blocks({{5, 105, 5, 105, 0, 10}}), settings);
  };
  const Supported half = at(50);
  const Supported normal = at(100);
  const Supported twice = at(200);
  const auto tips = [](const Supported& s) { return s.counts.all() + s.counts.unreached(); };
  EXPECT_GE(tips(normal), 400U / 12);
  EXPECT_NEAR(2.0 * tips(half) / tips(normal), 1, 0.25);
  EXPECT_NEAR(0.5 * tips(twice) / tips(normal), 1, 0.25);
  EXPECT_LE(half.hang(), kReach / 2 * std::sqrt(2.0) + kRounded);
  EXPECT_LE(twice.hang(), kReach / 2 / std::sqrt(2.0) + kRounded);
}

TEST(Supports, GrowNoFasterThanTheAreaWithTheSize) {
  // A raised ball of 8 mm, and larger ones, in pixels of 0.2 mm.
  const auto tips = [](double scale) {
    const auto radius = static_cast<std::uint32_t>(20 * scale);
    const std::uint32_t side = 2 * radius + 10;
    SupportSettings settings;
    settings.stand = SupportStand::kRaised;
    const Supported s(cubic_grid(side, 2 * radius, 0.2F), ball(side / 2, side / 2, radius, radius), settings);
    return s.counts.all() + s.counts.unreached();
  };
  const double smallest = tips(1);
  EXPECT_GT(smallest, 3);
  for (const double scale : {1.5, 2.0, 3.0}) EXPECT_LE(tips(scale), 1.2 * scale * scale * smallest) << scale;
}

TEST(Supports, EndOnThePlateOnlyIfAsked) {
  // Two slabs on a post, which leave no room beside the lower one; the upper one reaches beyond it at one side only.
  const Inside shape = blocks({{0, 44, 0, 64, 0, 10}, {0, 10, 0, 64, 10, 48}, {0, 64, 0, 64, 40, 48}});
  SupportSettings settings = on_the_plate();
  settings.max_bridge_length = 2;
  const Supported anywhere(shape, settings);
  EXPECT_GT(anywhere.counts.on_object, 0U);
  EXPECT_EQ(anywhere.counts.unreached(), 0U);
  settings.buildplate_only = true;
  const Supported s(shape, settings);
  EXPECT_EQ(s.counts.on_object, 0U);
  EXPECT_GT(s.counts.unreached(), 0U);
  EXPECT_GT(s.counts.on_plate, 0U);
  for (std::size_t k = 10; k < 20; ++k) {
    for (std::uint32_t r = 0; r < kSide; ++r) {
      for (std::uint32_t c = 10; c < 44; ++c) EXPECT_FALSE(s.masks[k].at(c, r)) << c << ' ' << r << ' ' << k;
    }
  }
}

TEST(Supports, EndWithTheObjectIfASpeckAboveItIsLeftOut) {
  const Supported s(cubic_grid(kSide, 27), blocks({{10, 54, 10, 54, 0, 20}, {30, 33, 30, 32, 25, 27}}));
  EXPECT_EQ(s.counts.specks, 1U);
  ASSERT_EQ(s.masks.size(), 20U);
  EXPECT_EQ(s.masks.back().count(), 44U * 44U);
}

TEST(Supports, HoldWhatIsMoreThanASpeck) {
  // 9 pixels; and as small as a speck, but 3 layers high: its third layer gets a tip.
  for (const Block& block : {Block{36, 39, 30, 33, 18, 20}, Block{36, 38, 30, 32, 17, 20}}) {
    const Supported s(slab_over(block));
    ASSERT_EQ(s.counts.islands, 1U);
    EXPECT_EQ(s.tips()[0].first, block.layer == 18 ? 18 : 19);
    EXPECT_EQ(s.counts.specks, block.layer == 18 ? 0U : 1U);
    EXPECT_EQ(floating_islands(s.masks), 0U);
  }
}

TEST(Supports, TakeAndReturnTheStatedBytes) {
  Solid solid(cubic_grid(kSide, 48), ball(32, 32, 27, 20));
  const PrintGrid& grid = solid.rrep.grid;
  ArenaBlock arena(find_supports_bytes(grid) + Arena::kAlignment);
  SupportCounts counts;
  const Supports supports =
      value_of(find_supports(solid.rrep, on_the_plate(), PrintGrid::kMaxLayers, *arena, nullptr, counts));
  EXPECT_EQ(arena->top_used(), 0U);
  EXPECT_EQ(arena->bottom_used(), Arena::rounded(supports.list.size_bytes()));
  EXPECT_LE(arena->peak(), find_supports_bytes(grid));
  EXPECT_GE(2 * arena->peak(), find_supports_bytes(grid));
}

TEST(Supports, TakeNoMoreThanTheStatedBytesWithThousandsOfSpecks) {
  Solid solid(cubic_grid(kSide, 48), [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return k < 4 || (k % 2 == 0 && k < 36 && c % 3 == 1 && r % 3 == 1);
  });
  solid.rrep.is_exact = true;  // so that single pixels are printed
  ArenaBlock arena(32 * kMiB);
  solid.move_to(*arena);
  const auto pixels = [&] {
    std::uint64_t sum = 0;
    for (const Pixels& mask : solid.masks()) sum += mask.count();
    return sum;
  };
  const std::uint64_t pixels_before = pixels();
  const std::size_t before = arena->used();
  arena->reset_peak();
  const std::size_t planned = find_supports_bytes(solid.rrep, on_the_plate());
  SupportCounts counts;
  value_of(find_supports(solid.rrep, on_the_plate(), PrintGrid::kMaxLayers, *arena, nullptr, counts));
  EXPECT_GT(counts.specks, 6000U);
  EXPECT_EQ(counts.lost_pixels, pixels_before - pixels());
  EXPECT_LE(arena->peak() - before, planned);
}

TEST(Supports, AreRefusedIfTheArenaIsFull) {
  Solid solid(cubic_grid(kSide, 48), ball(32, 32, 27, 20));
  std::size_t enough = 0;
  {
    ArenaBlock arena(32 * kMiB);
    SupportCounts counts;
    ASSERT_TRUE(find_supports(solid.rrep, on_the_plate(), PrintGrid::kMaxLayers, *arena, nullptr, counts).has_value());
    enough = arena->peak();
  }
  for (const std::size_t bytes : {enough / 8, enough / 2, enough - Arena::kAlignment}) {
    ArenaBlock arena(bytes);
    SupportCounts counts;
    const auto supports = find_supports(solid.rrep, on_the_plate(), PrintGrid::kMaxLayers, *arena, nullptr, counts);
    ASSERT_FALSE(supports.has_value());
    EXPECT_EQ(supports.error().code(), ErrorCode::kOutOfMemory);
    EXPECT_THAT(supports.error().message(), HasSubstr("needs"));
    EXPECT_THAT(supports.error().message(), HasSubstr("of the arena's"));
    EXPECT_EQ(arena->used(), 0U);
  }
}

TEST(Supports, AreRefusedIfTheListIsFull) {
  // In the air, a block of 3 x 3 pixels in every 5 x 5: 676 islands.
  const PrintGrid grid = cubic_grid(128, 4);
  ASSERT_LT(most_tips(grid), 676U);
  Solid solid(grid, [](std::uint32_t c, std::uint32_t r, std::uint32_t k) { return k > 1 && c % 5 < 3 && r % 5 < 3; });
  ArenaBlock arena(32 * kMiB);
  SupportCounts counts;
  const auto supports = find_supports(solid.rrep, on_the_plate(), PrintGrid::kMaxLayers, *arena, nullptr, counts);
  ASSERT_FALSE(supports.has_value());
  EXPECT_EQ(supports.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_THAT(supports.error().message(), HasSubstr("supports: more than 256 are needed up to layer 2 of 4"));
  EXPECT_EQ(arena->used(), 0U);
}

TEST(Supports, HaveRoomOnCoarsePixels) {
  // In the air, a block of 2 x 2 pixels in every 5 x 5: 400 islands, 2.5 mm apart.
  const PrintGrid grid = cubic_grid(100, 4, 0.5F);
  Solid solid(grid, [](std::uint32_t c, std::uint32_t r, std::uint32_t k) { return k > 1 && c % 5 < 2 && r % 5 < 2; });
  ArenaBlock arena(32 * kMiB);
  solid.move_to(*arena);
  SupportCounts counts;
  const auto supports =
      value_of(find_supports(solid.rrep, on_the_plate(), PrintGrid::kMaxLayers, *arena, nullptr, counts));
  EXPECT_EQ(supports.tips(), 400U);
}

TEST(Supports, HaveRoomOnPanelsOfAnySize) {
  // 2K, and 400 mm square: a tip for each 4 mm2, as many as a flat underside of that size takes.
  EXPECT_EQ(most_tips({.columns = 1440, .rows = 2560, .layers = 1, .pitch_x_mm = 0.04725F, .pitch_y_mm = 0.04725F}),
            16384U);
  EXPECT_EQ(most_tips({.columns = 4000, .rows = 4000, .layers = 1, .pitch_x_mm = 0.1F, .pitch_y_mm = 0.1F}), 40'000U);
}

TEST(Supports, StopWhenAsked) {
  StopAtThird stop;
  Solid solid(cubic_grid(kSide, 48), ball(32, 32, 27, 20));
  ArenaBlock arena(32 * kMiB);
  SupportCounts counts;
  const auto supports = find_supports(solid.rrep, on_the_plate(), PrintGrid::kMaxLayers, *arena, &stop, counts);
  ASSERT_FALSE(supports.has_value());
  EXPECT_EQ(supports.error().code(), ErrorCode::kCancelled);
  EXPECT_EQ(arena->used(), 0U);
}

}  // namespace support_finder_test
}  // namespace plumbline
