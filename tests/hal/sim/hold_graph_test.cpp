/// What tears, against all possible cuts.

#include "hal/sim/part/hold_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
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

TEST(HoldGraph, TearsExactlyWhenTheSmallestCutIsTooWeak) {
  // Random parts of up to nine limbs. Every limb may be cut off at its joints or at its neck, or stay: all cuts are tried.
  std::mt19937 random(4);
  const auto newtons = [&] { return std::uniform_int_distribution(1, 20)(random) * 1.0; };
  int torn = 0;
  for (int run = 0; run < 400; ++run) {
    HoldGraph graph;
    struct Edge {
      std::uint32_t from, to;  // vertices: 0 is the plate, 2 l - 1 and 2 l are limb l's top and bottom
      double newtons;
    };
    std::vector<Edge> edges;
    std::vector<std::uint32_t> leaves;
    const std::uint32_t limbs = std::uniform_int_distribution(1U, 6U)(random);
    std::vector<bool> goes_on(limbs + 1, false);
    for (std::uint32_t l = 1; l <= limbs; ++l) {
      std::vector<Joint> joints;
      for (std::uint32_t above = 0; above < l; ++above) {
        if (above + 1 < l && random() % 3 != 0) continue;
        joints.push_back({.limb = above, .newtons = newtons(), .share = 0.1});
        goes_on[above] = true;
        edges.push_back({above == 0 ? 0 : 2 * above, 2 * l - 1, joints.back().newtons});
      }
      ASSERT_EQ(graph.begin_limb(joints, in_layer(2 * l), 1), l);
      const double neck = newtons();
      graph.extend(l, neck, in_layer(2 * l + 1), 1);
      edges.push_back({2 * l - 1, 2 * l, neck});
    }
    std::vector<HoldGraph::Load> loads;
    for (std::uint32_t l = 1; l <= limbs; ++l) {
      if (!goes_on[l]) loads.push_back({l, std::uniform_real_distribution(0.1, 9.0)(random)});
    }
    // The load that some set of vertices asks for beyond the joints that hold it.
    double worst = 0;
    for (std::uint32_t set = 0; set < 1U << (2 * limbs); ++set) {
      const auto in = [&](std::uint32_t vertex) { return vertex > 0 && (set >> (vertex - 1) & 1U) != 0; };
      double too_much = 0;
      for (const auto& load : loads) too_much += in(2 * load.limb) ? load.newtons : 0;
      for (const Edge& edge : edges) too_much -= in(edge.from) != in(edge.to) ? edge.newtons : 0;
      worst = std::max(worst, too_much);
    }
    const auto tears = graph.pull(loads);
    EXPECT_EQ(tears.empty(), worst <= 0) << run << ": " << worst;
    double too_much = 0;
    for (const auto& tear : tears) {
      EXPECT_GT(tear.asked_n, tear.held_n);
      too_much += tear.asked_n - tear.held_n;
    }
    EXPECT_NEAR(too_much, worst, 1e-6) << run;
    torn += tears.empty() ? 0 : 1;
    // What is left holds.
    std::vector<HoldGraph::Load> left;
    for (const auto& load : loads) {
      if (!graph.lost(load.limb, 2 * load.limb + 1)) left.push_back(load);
    }
    EXPECT_THAT(graph.pull(left), IsEmpty()) << run;
  }
  EXPECT_GT(torn, 50);
  EXPECT_LT(torn, 350);
}

}  // namespace
}  // namespace plumbline
