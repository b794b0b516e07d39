/// What tears of small graphs. tears_test.cpp tries all cuts of small parts.

#include "hal/sim/part/hold_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using Joint = HoldGraph::Joint;

HoldGraph::Place in_layer(std::uint32_t layer) { return {.layer = layer, .column = layer, .row = 0}; }

TEST(HoldGraph, TearsAtTheNeckOfALimb) {
  HoldGraph graph;
  const Joint plate{.limb = HoldGraph::kPlate, .newtons = 9};
  const std::uint32_t limb = graph.begin_limb({&plate, 1}, in_layer(0), 1);
  graph.extend(limb, 8, in_layer(1), 2);
  graph.extend(limb, 3, in_layer(2), 4);
  graph.extend(limb, 5, in_layer(3), 8);
  EXPECT_THAT(graph.pull(std::vector{HoldGraph::Load{limb, 3}}), IsEmpty());
  const auto tears = graph.pull(std::vector{HoldGraph::Load{limb, 3.01}});
  ASSERT_THAT(tears, SizeIs(1));
  EXPECT_EQ(tears[0].place.layer, 2U);
  EXPECT_DOUBLE_EQ(tears[0].held_n, 3);
  EXPECT_DOUBLE_EQ(tears[0].asked_n, 3.01);
  EXPECT_EQ(tears[0].mm3, 12);
  EXPECT_THAT(tears[0].loads, ElementsAre(0));
  EXPECT_FALSE(graph.lost(limb, 1));
  EXPECT_TRUE(graph.lost(limb, 2));
}

TEST(HoldGraph, SharesALoadAmongUnequalLegs) {
  HoldGraph graph;
  const Joint plate{.limb = HoldGraph::kPlate, .newtons = 100};
  std::vector<Joint> legs;
  for (const double newtons : {1.0, 2.0, 4.0}) {
    legs.push_back({.limb = graph.begin_limb({&plate, 1}, in_layer(0), 1), .newtons = newtons});
  }
  const std::uint32_t body = graph.begin_limb(legs, in_layer(1), 10);
  EXPECT_THAT(graph.pull(std::vector{HoldGraph::Load{body, 6.99}}), IsEmpty());
  const auto tears = graph.pull(std::vector{HoldGraph::Load{body, 7.01}});
  ASSERT_THAT(tears, SizeIs(1));
  EXPECT_EQ(tears[0].mm3, 10) << "the legs stay";
  for (const Joint& leg : legs) EXPECT_FALSE(graph.lost(leg.limb, 0));
}

TEST(HoldGraph, ABodyHeldByTwoLegsHoldsAThirdBranchThroughEither) {
  // A weak leg and a strong one meet in a body. What hangs below the body pulls at both.
  HoldGraph graph;
  const Joint plate{.limb = HoldGraph::kPlate, .newtons = 100};
  const std::uint32_t weak = graph.begin_limb({&plate, 1}, in_layer(0), 1);
  const std::uint32_t strong = graph.begin_limb({&plate, 1}, in_layer(0), 1);
  graph.extend(weak, 1, in_layer(1), 1);
  graph.extend(strong, 5, in_layer(1), 1);
  const std::vector<Joint> legs = {{.limb = weak, .newtons = 50}, {.limb = strong, .newtons = 50}};
  const std::uint32_t body = graph.begin_limb(legs, in_layer(2), 1);
  const Joint half{.limb = body, .newtons = 50, .share = 0.5};
  const std::uint32_t left = graph.begin_limb({&half, 1}, in_layer(3), 1);
  const std::uint32_t right = graph.begin_limb({&half, 1}, in_layer(3), 1);
  EXPECT_THAT(graph.pull(std::vector<HoldGraph::Load>{{left, 5.5}, {right, 0.4}}), IsEmpty());
  const auto tears = graph.pull(std::vector<HoldGraph::Load>{{left, 5.5}, {right, 0.6}});
  ASSERT_THAT(tears, SizeIs(1));
  EXPECT_DOUBLE_EQ(tears[0].held_n, 6);
  EXPECT_THAT(tears[0].loads, ElementsAre(0, 1));
  EXPECT_TRUE(graph.lost(weak, 1));
  EXPECT_FALSE(graph.lost(weak, 0));
}

}  // namespace
}  // namespace plumbline
