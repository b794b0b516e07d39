#include "firmware/print/job/print_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "firmware/print/job/sliced_archive.hpp"

namespace plumbline::firmware {
namespace {

using namespace plumbline::literals;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

PrintProfile profile() { return read_print_profile(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml").value(); }
MachineFile machine() { return *read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value().machine; }
PrintPlan plan(std::uint32_t layers = 1000) { return plan_print(profile(), machine(), 0.05, layers).value(); }

double seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

TEST(PrintPlan, ExposesBottomLayersLongerAndFadesInEqualSteps) {
  const auto p = plan();  // 30 s for 5 layers, 8 to fade, then 2.5 s
  for (std::uint32_t layer = 0; layer < 5; ++layer) EXPECT_EQ(exposure_of(p, layer), 30s);
  for (std::uint32_t j = 1; j <= 8; ++j) {
    EXPECT_NEAR(seconds(exposure_of(p, 4 + j)), 30 + (2.5 - 30) * j / 9.0, 1e-9) << "step " << j;
  }
  EXPECT_EQ(exposure_of(p, 13), 2500ms);
  EXPECT_EQ(exposure_of(p, 999), 2500ms);
}

TEST(PrintPlan, WithoutAFadeChangesFromBottomToNormalAtOnce) {
  auto settings = profile();
  settings.faded_layers = 0;
  const auto p = plan_print(settings, machine(), 0.05, 100).value();
  EXPECT_EQ(exposure_of(p, 4), 30s);
  EXPECT_EQ(exposure_of(p, 5), 2500ms);
}

TEST(PrintPlan, CuresLayerKAtItsUpperFace) {
  const auto p = plan();
  EXPECT_EQ(height_of(p, 0), ZPosition(50_um));
  EXPECT_EQ(height_of(p, 999), ZPosition(50_mm));
}

TEST(PrintPlan, TakesTheHeightOfAnArchivesFirstLayer) {
  ArchiveSettings settings;
  settings.value(PrintKey::kInitialLayerHeight) = 0.3;
  const auto p = plan_print(*profile_of(profile(), settings, "part.sl1"), machine(), 0.05, 3335).value();
  EXPECT_EQ(height_of(p, 0), ZPosition(300_um));
  EXPECT_EQ(height_of(p, 1), ZPosition(350_um));
  EXPECT_FALSE(plan_print(*profile_of(profile(), settings, "part.sl1"), machine(), 0.05, 3336)) << "0.05 mm too high";
  settings.value(PrintKey::kInitialLayerHeight) = 0.02;
  EXPECT_EQ(height_of(*plan_print(*profile_of(profile(), settings, ""), machine(), 0.05, 9), 1), ZPosition(70_um));
}

TEST(PrintPlan, HeightsAddUpWithoutRounding) {
  const auto p = plan_print(profile(), machine(), 0.0123, 10000).value();
  EXPECT_EQ(height_of(p, 9999).above_film().nanometres(), 123'000'000);
}

TEST(PrintPlan, ExposesEachLayerOfAnAdaptivePrintForItsHeight) {
  LayerSteps steps;
  for (int i = 0; i < 13; ++i) EXPECT_TRUE(steps.add(3));  // bottom and faded layers
  for (const std::uint32_t step : {5U, 5U, 1U, 1U, 1U, 3U}) EXPECT_TRUE(steps.add(step));
  auto settings = profile();
  const auto p = plan_print(settings, machine(), 0.02, 55, steps).value();
  EXPECT_EQ(p.layers, 19U);
  EXPECT_EQ(height_of(p, 0), ZPosition(60_um));
  EXPECT_EQ(height_of(p, 14), ZPosition(980_um));
  EXPECT_EQ(height_of(p, 15), ZPosition(1000_um));
  EXPECT_EQ(height_of(p, 18), ZPosition(1100_um));
  EXPECT_EQ(thickness_of(p, 14), 100_um);
  // Jacobs: a layer that is higher by d needs exp(d / Dp) of the light to be cured as far beyond itself.
  const std::array<std::pair<std::uint32_t, double>, 4> layers = {{{0, 0.06}, {14, 0.1}, {15, 0.02}, {18, 0.06}}};
  for (const auto& [layer, mm] : layers) {
    const double usual = layer == 0 ? 30 : 2.5;
    EXPECT_NEAR(seconds(exposure_of(p, layer)), usual * std::exp((mm - 0.05) / 0.12), 1e-6) << layer;
  }
  nanoseconds sum{};
  for (std::uint32_t layer = 0; layer < p.layers; ++layer) sum += layer_time(p, layer);
  EXPECT_EQ(remaining_time(p, 0), sum);
  settings.exposure_time = 30;
  auto cautious = machine();
  cautious.max_exposure_s = 40;
  EXPECT_TRUE(plan_print(settings, cautious, 0.05, 55));
  EXPECT_FALSE(plan_print(settings, cautious, 0.02, 55, steps)) << "45.5 s for 0.1 mm";
}

TEST(PrintPlan, LiftsSlowlyWhilePeelingAndRetractsSlowlyNearTheFilm) {
  const auto p = plan();
  const auto up = lift_from(p, 9);
  EXPECT_EQ(up[0], (StageMove{ZPosition(4.5_mm), mm_per_min(60)}));
  EXPECT_EQ(up[1], (StageMove{ZPosition(7.5_mm), mm_per_min(180)}));
  const auto down = retract_to(p, 10);
  EXPECT_EQ(down[0], (StageMove{ZPosition(2.55_mm), mm_per_min(180)}));
  EXPECT_EQ(down[1], (StageMove{ZPosition(0.55_mm), mm_per_min(60)}));
}

TEST(PrintPlan, PauseRaisesThePartWithinTheTravel) {
  const auto p = plan(3000);
  EXPECT_EQ(pause_above(p, 0).target, ZPosition(50.05_mm));
  EXPECT_EQ(pause_above(p, 2999).target, ZPosition(174_mm)) << "150 + 50 is above the end stop's 175 - 1";
}

TEST(PrintPlan, LayerTimeIsExposureWaitsAndMoves) {
  const auto p = plan();
  // sim2k: 100 mm/s2. Trapezoids: d / v + v / a. A mask takes one frame and 20 ms to settle.
  const auto move = [](double mm, double mm_min) { return mm / (mm_min / 60) + mm_min / 60 / 100; };
  const double expected =
      move(7 - 0.05 - 2, 180) + move(2, 60) + 0.5 + 2.5 + 2 * (1.0 / 60 + 0.02) + move(4, 60) + move(3, 180);
  EXPECT_NEAR(seconds(layer_time(p, 100)), expected, 1e-6);
}

TEST(PrintPlan, PrintTimeIsTheSumOfItsLayersAndTheMovesDownAndUp) {
  const auto p = plan(200);
  nanoseconds sum{};
  for (std::uint32_t layer = 0; layer < 200; ++layer) sum += layer_time(p, layer);
  EXPECT_EQ(remaining_time(p, 0), sum);
  EXPECT_EQ(remaining_time(p, 199), layer_time(p, 199));
  EXPECT_EQ(remaining_time(p, 200), 0s);
  EXPECT_EQ(remaining_time(p, 7),
            sum - 5 * layer_time(p, 4) - layer_time(p, 5) - layer_time(p, 6) - layer_time(p, 0) + layer_time(p, 1))
      << "the first layer has no way down";
  const auto move = [](double mm, double mm_min) { return mm / (mm_min / 60) + mm_min / 60 / 100; };
  // Down fast to where the lift of a layer ends, then as to any layer; up, and home: 1 mm, 2 mm back, 2 mm slowly, 1 mm back.
  const double down = move(174 - 7.05, 300) + move(5, 180) + move(2, 60);
  const double home = move(1, 300) + move(2, 300) + move(2, 30) + move(1, 300);
  EXPECT_NEAR(seconds(print_time(p) - sum), down + move(174 - 17, 300) + home, 1e-6);
}

/// Most light in any minute by brute force, from the times of all exposures.
nanoseconds most_light_by_brute_force(const PrintPlan& plan) {
  std::vector<std::pair<nanoseconds, nanoseconds>> lit;
  nanoseconds now{};
  for (std::uint32_t k = 0; k < plan.layers; ++k) {
    // The dark part of a layer's time lies before its light here. That moves all of it by the same.
    if (k > 0) now += layer_time(plan, k) - exposure_of(plan, k) - 2 * plan.mask_change;
    lit.emplace_back(now, now + exposure_of(plan, k));
    now = lit.back().second;
  }
  nanoseconds most{};
  for (const auto& last : lit) {
    nanoseconds light{};
    for (const auto& one : lit) {
      const auto from = std::max(one.first, last.second - 60s);
      light += std::max(std::min(one.second, last.second) - from, 0ns);
    }
    most = std::max(most, light);
  }
  return most;
}

TEST(PrintPlan, FindsTheMostLightInAMinute) {
  std::mt19937 random(5);
  const auto pick = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  for (int round = 0; round < 50; ++round) {
    auto one = profile();
    one.exposure_time = pick(0.5, 20);
    one.initial_exposure_time = pick(0.5, 30);
    one.bottom_layer_count = static_cast<std::uint32_t>(1 + random() % 10);
    one.faded_layers = static_cast<std::uint32_t>(random() % 10);
    one.wait_time_after_lift = pick(0, 5);
    const auto plan = plan_print(one, machine(), 0.05, static_cast<std::uint32_t>(1 + random() % 200));
    ASSERT_TRUE(plan) << plan.error().message();
    EXPECT_EQ(most_light_in_a_minute(*plan).count(), most_light_by_brute_force(*plan).count()) << round;
  }
}

TEST(PrintPlan, RefusesMoreLightInAMinuteThanTheLampMayGive) {
  auto bright = profile();
  bright.initial_exposure_time = 26;
  bright.bottom_layer_count = 3;
  bright.lift_height = 0.5;
  bright.lift_height2 = 0;
  bright.retract_height2 = 0;
  bright.wait_time_after_lift = 3;
  auto lamp = machine();
  EXPECT_TRUE(plan_print(bright, lamp, 0.05, 100)) << "two exposures, and twice over 3 s of dark";
  lamp.max_light_per_minute_s = 50;
  const auto refused = plan_print(bright, lamp, 0.05, 100);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), ErrorCode::kExposureTooLong);
  EXPECT_THAT(refused.error().message(), HasSubstr("of light in a minute, this printer's lamp may be lit for 50 s"));
  bright.wait_time_after_lift = 10;
  EXPECT_TRUE(plan_print(bright, lamp, 0.05, 100));
}

TEST(PrintPlan, BlamesTheArchiveForItsExposures) {
  const auto message = [](const ArchiveSettings& settings, const MachineFile& lamp) -> std::string {
    const auto refused = plan_print(*profile_of(profile(), settings, "part.sl1"), lamp, 0.05, 100);
    if (refused) return "taken";
    EXPECT_EQ(refused.error().code(), ErrorCode::kExposureTooLong);
    return refused.error().message();
  };
  ArchiveSettings settings;
  EXPECT_EQ(message(settings, machine()), "taken");
  settings.value(PrintKey::kInitialExposureTime) = 61;
  EXPECT_THAT(message(settings, machine()),
              AllOf(HasSubstr("part.sl1: its exposure of the first layers is 61 s, this printer's lamp may be lit for "
                              "60 s at most"),
                    HasSubstr("Slice it again with a shorter exposure"), Not(HasSubstr("profile"))));
  settings.value(PrintKey::kExposureTime) = 62;
  EXPECT_THAT(message(settings, machine()), HasSubstr("part.sl1: its exposure of a layer is 62 s"));
  auto lamp = machine();
  lamp.max_light_per_minute_s = 20;
  settings.value(PrintKey::kExposureTime) = 50;
  settings.value(PrintKey::kInitialExposureTime) = 55;
  EXPECT_THAT(message(settings, lamp), HasSubstr("part.sl1: its exposures give up to "));

  // The profile's own exposure is the profile's fault, even with an archive.
  auto bright = profile();
  bright.initial_exposure_time = 61;
  settings.value(PrintKey::kExposureTime) = 2;
  settings.value(PrintKey::kInitialExposureTime).reset();
  const auto refused = plan_print(*profile_of(bright, settings, "part.sl1"), machine(), 0.05, 100);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("lower initial_exposure_time"));
}

TEST(PrintPlan, RefusesWhatTheMachineCannotDo) {
  auto fast = profile();
  fast.retract_speed = 301;
  const auto too_fast = plan_print(fast, machine(), 0.05, 100);
  ASSERT_FALSE(too_fast);
  EXPECT_EQ(too_fast.error().code(), ErrorCode::kBadSetting);
  EXPECT_THAT(too_fast.error().message(), HasSubstr("retract_speed is 301 mm/min"));

  auto bright = profile();
  bright.initial_exposure_time = 61;
  const auto too_long = plan_print(bright, machine(), 0.05, 100);
  ASSERT_FALSE(too_long);
  EXPECT_EQ(too_long.error().code(), ErrorCode::kExposureTooLong);
  EXPECT_THAT(too_long.error().message(), HasSubstr("lower initial_exposure_time"));

  EXPECT_TRUE(plan_print(profile(), machine(), 0.05, 3340)) << "167 + 7 mm is the highest point";
  const auto too_high = plan_print(profile(), machine(), 0.05, 3341);
  ASSERT_FALSE(too_high);
  EXPECT_EQ(too_high.error().code(), ErrorCode::kDoesNotFit);
}

TEST(PrintPlan, CureDepthFollowsTheWorkingCurve) {
  auto settings = profile();  // Dp 0.12 mm, Ec 3.2 mJ/cm2
  const Irradiance lamp(3.5);
  EXPECT_NEAR(cure_depth(settings, lamp, 2500ms).millimetres(), 0.12 * std::log(8.75 / 3.2), 1e-6);
  EXPECT_LT(cure_depth(settings, lamp, 500ms), 0_um) << "1.75 mJ/cm2 set nothing";
}

TEST(PrintPlan, EveryProfileCuresThroughItsLayerOnEveryPrinter) {
  for (const char* name : {"standard", "tough", "draft"}) {
    for (const char* printer : {"mono2k", "mono4k", "mono8k", "sim2k"}) {
      const std::string board = std::string(PLUMBLINE_SOURCE_DIR "/board/") + printer + ".toml";
      const auto settings = read_print_profile(name, board).value();
      const auto target = *read_board_file(board).value().machine;
      const auto p = plan_print(settings, target, settings.layer_height, 100);
      ASSERT_TRUE(p) << p.error().message();
      EXPECT_GT(cure_depth(settings, Irradiance(target.power_mw_cm2), p->exposure), p->layer_height)
          << name << " on " << printer;
    }
  }
}

TEST(PrintPlan, ResinIsTheVolumeOfThePixelsAndCostsItsShareOfTheBottle) {
  EXPECT_NEAR(resin_ml(1'000'000, 0.1, 0.1, 0.05), 0.5, 1e-12);
  auto settings = profile();
  EXPECT_NEAR(resin_cost(settings, 100), 3.0, 1e-12);
  settings.bottle_volume = 0;
  EXPECT_EQ(resin_cost(settings, 100), 0);
}

}  // namespace
}  // namespace plumbline::firmware
