#include "slicer/supports/stand.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slicer/support/solid.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

constexpr std::uint32_t kLift = 58;  ///< layers

struct Stood {
  explicit Stood(const Inside& inside, const SupportSettings& settings = {}, std::uint32_t most_layers = 1000,
                 std::uint32_t layers = 48)
      : solid(cubic_grid(64, layers), inside),
        arena(4 * kMiB),
        stand(choose_stand(solid.rrep, settings, most_layers, *arena)) {}

  Solid solid;
  ArenaBlock arena;
  Expected<Stand> stand;
};

TEST(Stand, IsOnThePlateForAFlatUnderside) {
  const Stood cube(blocks({{20, 44, 20, 44, 0, 40}}));
  ASSERT_TRUE(cube.stand);
  EXPECT_EQ(cube.stand->sunk, 0U);
  EXPECT_EQ(cube.stand->lifted, 0U);
}

TEST(Stand, SinksToTheFirstLayerOfEnoughArea) {
  // A speck below a cube; a tenth of the cube's section is 57.6 pixels. 0.3 mm are 3 layers, and a fortieth of 140.
  const auto on_a = [](std::uint32_t side, std::uint32_t layers) {
    return Stood(blocks({{30, 30 + side, 30, 30 + side, 0, layers}, {20, 44, 20, 44, layers, 140}}), {}, 1000, 140);
  };
  EXPECT_EQ(on_a(7, 2).stand->sunk, 2U);
  EXPECT_EQ(on_a(7, 2).stand->lifted, 0U);
  EXPECT_EQ(on_a(7, 2).stand->sunk_pixels, 2U * 7 * 7);
  EXPECT_EQ(on_a(7, 3).stand->sunk, 3U);
  EXPECT_EQ(on_a(8, 3).stand->sunk, 3U);
  EXPECT_EQ(on_a(7, 4).stand->sunk, 0U);
  EXPECT_EQ(on_a(7, 4).stand->lifted, kLift);
  EXPECT_EQ(on_a(7, 4).stand->sunk_pixels, 0U);
}

TEST(Stand, IsOnAFootThatHasATenthOfTheLargestSection) {
  const auto on_a = [](std::uint32_t side) {
    return Stood(blocks({{30, 30 + side, 30, 30 + side, 0, 40}, {20, 44, 20, 44, 15, 40}}));
  };
  EXPECT_EQ(on_a(8).stand->lifted, 0U);
  EXPECT_EQ(on_a(7).stand->lifted, kLift);
}

TEST(Stand, LiftsWhatLiesOnOneEndOfItsUnderside) {
  // A block of 24 x 24 pixels whose underside begins 0.5 mm above the plate, but for `columns` of it.
  const auto on_a_foot_of = [](std::uint32_t columns) {
    return Stood(blocks({{20, 20 + columns, 20, 44, 0, 40}, {20, 44, 20, 44, 5, 40}}));
  };
  EXPECT_EQ(on_a_foot_of(12).stand->lifted, 0U);
  EXPECT_EQ(on_a_foot_of(11).stand->lifted, kLift);
}

TEST(Stand, LiftsWhatIsNotFlatByElevationAndRaft) {
  const Inside round = ball(32, 32, 24, 24);
  EXPECT_EQ(Stood(round).stand->lifted, kLift);  // 5 mm and 0.8 mm
  SupportSettings settings;
  settings.object_elevation = 3;
  settings.pad_wall_thickness = 0;
  EXPECT_EQ(Stood(round, settings).stand->lifted, 30U);
  settings.object_elevation = 0;
  EXPECT_EQ(Stood(round, settings).stand->lifted, 0U);
}

TEST(Stand, IsAsAskedWhateverTheUnderside) {
  const Inside cube = blocks({{20, 44, 20, 44, 0, 40}});
  const Inside round = ball(32, 32, 24, 24);
  SupportSettings settings;
  settings.stand = SupportStand::kRaised;
  EXPECT_EQ(Stood(cube, settings).stand->lifted, kLift);
  EXPECT_EQ(Stood(cube, settings).stand->flat, std::nullopt);
  EXPECT_EQ(Stood(round, settings).stand->lifted, kLift);
  settings.pad_wall_thickness = 0;
  EXPECT_EQ(Stood(cube, settings).stand->lifted, 50U) << "without a raft";
  settings.stand = SupportStand::kPlate;
  EXPECT_EQ(Stood(cube, settings).stand->lifted, 0U);
  EXPECT_EQ(Stood(cube, settings).stand->flat, true);
  EXPECT_EQ(Stood(round, settings).stand->lifted, 0U);
  EXPECT_EQ(Stood(round, settings).stand->sunk, 0U);
  EXPECT_EQ(Stood(round, settings).stand->flat, false);
  EXPECT_TRUE(Stood(round, settings, 48).stand) << "the printer has no room for a lift";
}

TEST(Stand, SinksOnThePlateAlsoWhereThatIsAsked) {
  const Inside on_a_speck = blocks({{30, 37, 30, 37, 0, 2}, {20, 44, 20, 44, 2, 140}});
  SupportSettings settings;
  settings.stand = SupportStand::kPlate;
  EXPECT_EQ(Stood(on_a_speck, settings, 1000, 140).stand->sunk, 2U);
}

TEST(Stand, IsRefusedIfTheLiftedObjectIsTooHigh) {
  const Inside round = ball(32, 32, 24, 24);
  EXPECT_TRUE(Stood(round, {}, 48 + kLift).stand);
  const Stood high(round, {}, 47 + kLift);
  ASSERT_FALSE(high.stand);
  EXPECT_EQ(high.stand.error().code(), ErrorCode::kDoesNotFit);
  EXPECT_THAT(high.stand.error().message(), HasSubstr("supports lift it by 5.80 mm: 0.10 mm more than"));
}

TEST(Stand, MovesTheObjectAndNothingElse) {
  Stood round(ball(32, 32, 24, 24));
  const auto before = round.solid.masks();
  ASSERT_TRUE(stand_object(round.solid.rrep, *round.stand, *round.arena));
  const auto after = round.solid.masks();
  ASSERT_EQ(after.size(), before.size() + kLift);
  for (std::size_t k = 0; k < kLift; ++k) EXPECT_EQ(after[k].count(), 0U);
  for (std::size_t k = 0; k < before.size(); ++k) EXPECT_EQ(after[k + kLift], before[k]);
}

}  // namespace
}  // namespace plumbline
