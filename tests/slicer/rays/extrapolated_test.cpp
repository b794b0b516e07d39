#include "slicer/rays/extrapolated.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

#include "tests/slicer/support/winding_field.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr float kReach = 1.2F;  ///< mm

/// A ball that the ray through its centre enters at 5 mm and exits at 15 mm.
class ExtrapolatedCrossings : public ::testing::Test {
 protected:
  void settle(std::initializer_list<RayCrossing> crossings) {
    crossings_ = crossings;
    std::span<RayCrossing> left = crossings_;
    changed_ = settle_extrapolated(left, 10, 10, column_, kReach);
    crossings_.resize(left.size());
  }
  void fill(std::initializer_list<RayCrossing> crossings) {
    crossings_ = crossings;
    std::span<RayCrossing> left = crossings_;
    changed_ = fill_short_hollows(left, 10, 10, column_, kReach);
    crossings_.resize(left.size());
  }
  void expect_the_ball() const {
    ASSERT_EQ(crossings_.size(), 2U);
    EXPECT_NEAR(crossings_[0].depth, 5, 0.15);
    EXPECT_NEAR(crossings_[1].depth, 15, 0.15);
  }
  static constexpr RayCrossing measured(float depth) { return {depth, Evidence::kMeasured, false}; }
  static constexpr RayCrossing extrapolated(float depth) { return {depth, Evidence::kMeasured, true}; }

  WindingField field_{sphere(20000, 5, {10, 10, 10})};
  ColumnWinding column_ = field_.column(10, 10, 0.2F);
  std::vector<RayCrossing> crossings_;
  bool changed_ = false;
};

TEST_F(ExtrapolatedCrossings, StayWhereTheWindingNumberAgrees) {
  settle({extrapolated(5), extrapolated(15)});
  EXPECT_FALSE(changed_);
  ASSERT_EQ(crossings_.size(), 2U);
  EXPECT_EQ(crossings_[0].depth, 5);
  EXPECT_EQ(crossings_[0].evidence, Evidence::kMeasured);
  EXPECT_EQ(crossings_[1].depth, 15);
}

TEST_F(ExtrapolatedCrossings, MoveToWhereTheWindingNumberChanges) {
  settle({extrapolated(3), measured(15)});
  EXPECT_TRUE(changed_);
  expect_the_ball();
  EXPECT_EQ(crossings_[0].evidence, Evidence::kWinding);
  EXPECT_EQ(crossings_[1].evidence, Evidence::kMeasured);

  settle({measured(5), extrapolated(19.5F)});
  expect_the_ball();

  settle({measured(1), measured(2), extrapolated(7.5F), measured(15)});
  ASSERT_EQ(crossings_.size(), 4U);
  EXPECT_NEAR(crossings_[2].depth, 5, 0.15);
  settle({measured(5), extrapolated(12), measured(18), measured(19)});
  ASSERT_EQ(crossings_.size(), 4U);
  EXPECT_NEAR(crossings_[1].depth, 15, 0.15);
}

TEST_F(ExtrapolatedCrossings, AreRemovedWithTheSolidThatTheyMakeInTheAir) {
  settle({measured(1), extrapolated(2), measured(5), measured(15)});
  EXPECT_TRUE(changed_);
  expect_the_ball();
  settle({measured(5), measured(15), extrapolated(16), extrapolated(17)});
  expect_the_ball();
}

TEST_F(ExtrapolatedCrossings, AreRemovedWithTheHollowThatTheyMake) {
  settle({measured(5), measured(9), extrapolated(11), measured(15)});
  EXPECT_TRUE(changed_);
  expect_the_ball();
}

TEST_F(ExtrapolatedCrossings, AreTheOnlyOnesThatMove) {
  settle({measured(1), measured(2), measured(5), measured(9), measured(10), measured(15)});
  EXPECT_FALSE(changed_);
  EXPECT_EQ(crossings_.size(), 6U);
}

TEST_F(ExtrapolatedCrossings, DoNotMoveBeyondTheOutermostCrossing) {
  settle({extrapolated(7.5F), extrapolated(12)});
  EXPECT_FALSE(changed_);
  ASSERT_EQ(crossings_.size(), 2U);
  EXPECT_EQ(crossings_[0].depth, 7.5F);
  EXPECT_EQ(crossings_[1].depth, 12);
}

// The foot of a pin: the face around it is continued through it.
TEST_F(ExtrapolatedCrossings, AreRemovedAroundAHollowShorterThanASupport) {
  fill({measured(5), measured(8), measured(8.5F), measured(10), measured(10.5F), measured(15)});
  EXPECT_TRUE(changed_);
  expect_the_ball();
  fill({measured(5), measured(8), measured(9.5F), measured(15)});
  EXPECT_FALSE(changed_);
  EXPECT_EQ(crossings_.size(), 4U);
}

TEST_F(ExtrapolatedCrossings, StayAroundAShortGapOutside) {
  fill({measured(1), measured(2), measured(2.5F), measured(4), measured(5), measured(15)});
  EXPECT_FALSE(changed_);
  EXPECT_EQ(crossings_.size(), 6U);
}

TEST_F(ExtrapolatedCrossings, MayCoincideOrBeAbsent) {
  settle({measured(5), extrapolated(5), extrapolated(5), measured(15)});
  EXPECT_FALSE(changed_);
  settle({});
  EXPECT_FALSE(changed_);
  EXPECT_TRUE(crossings_.empty());
}

}  // namespace
}  // namespace plumbline
