#include "firmware/print/job/layer_exposures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace plumbline::firmware {
namespace {

using namespace plumbline::literals;
using namespace std::chrono_literals;
using ::testing::ElementsAre;

/// Two bottom layers of 30 s, three faded ones, then 2.5 s.
PrintPlan exposed(std::uint32_t grey_exposures, double foot_mm = 0) {
  PrintPlan plan;
  plan.layers = 20;
  plan.exposure = 2500ms;
  plan.initial_exposure = 30s;
  plan.bottom_layers = 2;
  plan.faded_layers = 3;
  plan.grey_exposures = grey_exposures;
  plan.elephant_foot = Distance::millimetres(foot_mm);
  plan.least_exposure = 100ms;
  return plan;
}

std::vector<nanoseconds> times(const LayerExposures& exposures) {
  std::vector<nanoseconds> times;
  for (const LayerExposure& exposure : exposures.all()) times.push_back(exposure.time);
  return times;
}

/// Of a pixel with k/2^n of the light.
nanoseconds light_of(const LayerExposures& exposures, std::uint32_t k) {
  nanoseconds light{};
  for (const LayerExposure& exposure : exposures.all()) {
    if ((exposure.shares >> k & 1U) != 0) light += exposure.time;
  }
  return light;
}

TEST(LayerExposures, AreOneWithoutGreyOrFoot) {
  const PrintPlan plan = exposed(3, 0.1);
  for (const std::uint32_t layer : {0U, 3U, 10U}) {
    EXPECT_THAT(times(exposures_of(plan, layer, {})), ElementsAre(exposure_of(plan, layer)));
  }
}

TEST(LayerExposures, OfGreyAreTheBitsOfItsSharesTheShortestFirst) {
  const PrintPlan plan = exposed(3);
  EXPECT_THAT(times(most_exposures_of(plan, 10)), ElementsAre(312'500us, 312'500us, 625ms, 1250ms));
  EXPECT_THAT(times(exposures_of(plan, 10, {.shares = 1U << 3})), ElementsAre(937'500us, 1562'500us))
      << "3/8 and the rest";
  EXPECT_THAT(times(exposures_of(plan, 10, {.shares = 1U << 4})), ElementsAre(1250ms, 1250ms));
  EXPECT_THAT(times(exposures_of(plan, 10, {.shares = 1U << 1 | 1U << 2})), ElementsAre(312'500us, 625ms, 1562'500us));
}

TEST(LayerExposures, AddUpToTheNanosecondAndGiveEachShareItsLight) {
  for (const std::uint32_t n : {1U, 2U, 3U, 4U}) {
    PrintPlan plan = exposed(n);
    for (const nanoseconds whole : {2500ms + 0ns, 3s + 1ns, 1'999'999'999ns, 119s + 123'456'789ns}) {
      plan.exposure = whole;
      const std::uint32_t steps = 1U << n;
      for (std::uint32_t shares = 0; shares < 1U << steps; shares += n == 4 ? 254 : 2) {
        const auto exposures = exposures_of(plan, 10, {.shares = shares});
        ASSERT_LE(exposures.count(), n + 1);
        ASSERT_EQ(exposures.begin(exposures.count()), whole);
        for (std::uint32_t k = 1; k < steps; ++k) {
          if ((shares >> k & 1U) == 0) continue;
          const auto off = light_of(exposures, k) - whole * k / steps;
          ASSERT_LT(std::max(off, -off), 5us) << k << " of " << steps;
        }
        for (std::uint32_t i = 0; i + 1 < exposures.count(); ++i) {
          ASSERT_EQ(exposures.all()[i].time % 1us, 0ns) << "as the journal keeps light";
          ASSERT_NE(exposures.all()[i].shares, exposures.all()[i + 1].shares) << "or they are one";
        }
      }
    }
  }
}

TEST(LayerExposures, AreNeverTooShortForTheLamp) {
  PrintPlan plan = exposed(4);
  EXPECT_EQ(grey_exposures_of(plan, 10), 4U) << "2.5 s / 16 = 0.156 s";
  plan.exposure = 1s;
  EXPECT_EQ(grey_exposures_of(plan, 10), 3U);
  plan.least_exposure = 300ms;
  EXPECT_EQ(grey_exposures_of(plan, 10), 1U);
  plan.exposure = 500ms;
  EXPECT_EQ(grey_exposures_of(plan, 10), 0U);
  EXPECT_EQ(most_exposures_of(plan, 10).count(), 1U);
  plan.elephant_foot = Distance::millimetres(0.1);
  plan.initial_exposure = 700ms;
  EXPECT_EQ(most_exposures_of(plan, 0).count(), 1U) << "0.2 s beyond a normal layer's";
}

TEST(LayerExposures, OfAFootGiveTheOutlineANormalLayersLight) {
  const PrintPlan plan = exposed(0, 0.1);
  for (std::uint32_t layer = 0; layer < 5; ++layer) {
    const auto exposures = most_exposures_of(plan, layer);
    ASSERT_THAT(times(exposures), ElementsAre(2500ms, exposure_of(plan, layer) - 2500ms)) << layer;
    EXPECT_FALSE(exposures.all()[0].inside);
    EXPECT_TRUE(exposures.all()[1].inside);
  }
  EXPECT_EQ(most_exposures_of(plan, 5).count(), 1U);
  EXPECT_EQ(most_exposures_of(exposed(3, 0.1), 0).count(), 5U) << "grey in the outline's light";
  PrintPlan shorter = plan;
  shorter.initial_exposure = 2s;
  EXPECT_EQ(most_exposures_of(shorter, 0).count(), 1U);
}

/// Of four strips of ten columns from 20 on.
PrintPlan tested() {
  PrintPlan plan = exposed(0, 0.1);
  plan.test = {.count = 4, .exposures = {1600ms, 2s, 2400ms, 2800ms}, .begin = 20, .end = 60};
  plan.exposure = 2800ms;
  return plan;
}

std::vector<std::uint32_t> begins(const LayerExposures& exposures) {
  std::vector<std::uint32_t> columns;
  for (const LayerExposure& exposure : exposures.all()) columns.push_back(exposure.from);
  return columns;
}

TEST(LayerExposures, OfATestAreTheShortestOfAllAndWhatEachStripGetsMore) {
  const PrintPlan plan = tested();
  const auto exposures = most_exposures_of(plan, 5);
  EXPECT_THAT(times(exposures), ElementsAre(1600ms, 400ms, 400ms, 400ms));
  EXPECT_THAT(begins(exposures), ElementsAre(0, 30, 40, 50))
      << "what stands before the object belongs to its first strip";
  EXPECT_EQ(exposures.begin(4), exposure_of(plan, 5));
  for (std::uint32_t layer = 0; layer < 5; ++layer) {
    EXPECT_THAT(times(most_exposures_of(plan, layer)), ElementsAre(2800ms, exposure_of(plan, layer) - 2800ms)) << layer;
  }
  PrintPlan eight = plan;
  eight.test = {.count = 8, .exposures = {1s, 2s, 3s, 4s, 5s, 6s, 7s, 8s}, .begin = 0, .end = 1000};
  EXPECT_EQ(most_exposures_of(eight, 10).count(), LayerExposures::kMost);
}

TEST(LayerExposures, OfATestAreFewerWhereStripsHaveNoPixels) {
  const PrintPlan plan = tested();
  const auto of = [&](std::uint32_t strips) { return exposures_of(plan, 10, {.strips = strips}); };
  EXPECT_THAT(times(of(0b0001)), ElementsAre(1600ms)) << "the rest would be black";
  EXPECT_THAT(times(of(0b0011)), ElementsAre(1600ms, 400ms));
  EXPECT_THAT(times(of(0b1001)), ElementsAre(1600ms, 1200ms));
  EXPECT_THAT(begins(of(0b1001)), ElementsAre(0, 30));
  EXPECT_THAT(times(of(0b1100)), ElementsAre(2400ms, 400ms)) << "the same mask three times is one exposure";
  EXPECT_THAT(begins(of(0b1100)), ElementsAre(0, 50));
  EXPECT_THAT(times(of(0)), ElementsAre(1600ms));
}

TEST(LayerExposures, FollowFromTheLightThatALayerHasHad) {
  const auto exposures = most_exposures_of(exposed(2), 10);  // 0.625 s, 0.625 s, 1.25 s
  EXPECT_EQ(exposures.at(0s), 0U);
  EXPECT_EQ(exposures.at(624'999us), 0U);
  EXPECT_EQ(exposures.at(625ms), 1U);
  EXPECT_EQ(exposures.at(1250ms), 2U);
  EXPECT_EQ(exposures.at(9s), 2U);
  EXPECT_EQ(exposures.begin(2), 1250ms);
}

TEST(LayerExposures, RoundLevelsToShares) {
  for (std::uint32_t level = 0; level < 256; ++level) {
    EXPECT_EQ(share_of(level, 3), static_cast<std::uint32_t>(std::lround(level * 8 / 255.0))) << level;
  }
  EXPECT_EQ(share_of(255, 4), 16U);
}

TEST(LayerExposures, TakeAMaskChangeEachOfTheTimeEstimates) {
  PrintPlan one = exposed(0), four = exposed(3);
  for (PrintPlan* plan : {&one, &four}) {
    plan->mask_change = 37ms;
    plan->layer_height = 50_um;
    plan->lift_speed = plan->lift_speed2 = plan->retract_speed = plan->retract_speed2 = mm_per_min(60);
    plan->acceleration = Acceleration(100);
    plan->fastest = mm_per_min(300);
    plan->highest = ZPosition(100_mm);
  }
  EXPECT_EQ(layer_time(four, 10) - layer_time(one, 10), 3 * 37ms);
  EXPECT_EQ(remaining_time(four, 0) - remaining_time(one, 0), 20 * 3 * 37ms);
  EXPECT_EQ(most_light_in_a_minute(four), most_light_in_a_minute(one));
  // Two masks of the layer have had their light.
  EXPECT_EQ(time_to_end(four, ZPosition(1_mm), 19, 625ms) - time_to_end(one, ZPosition(1_mm), 19, 625ms), 37ms);
  EXPECT_EQ(most_exposures(four), 80U);
}

}  // namespace
}  // namespace plumbline::firmware
