#include "firmware/print/job/plan_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

using namespace plumbline::literals;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

MachineFile stage_of_steps(double step_mm, double end_stop_mm = 175) {
  MachineFile machine = *read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value().machine;
  machine.full_steps_per_rotation = 200;
  machine.microsteps = 1;
  machine.rotation_distance_mm = step_mm * 200;
  machine.end_stop_height_mm = end_stop_mm;
  return machine;
}

PrintPlan layers_of(double height_mm, std::uint32_t layers) {
  const auto profile = read_print_profile(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml").value();
  PrintPlan plan = plan_print(profile, stage_of_steps(0.00125), 0.05, 1).value();
  plan.layers = layers;
  plan.layer_height = Distance::millimetres(height_mm);
  return plan;
}

/// A stage that takes one step after the other from its end stop until none brings it nearer.
class WalkingStage {
 public:
  WalkingStage(double step_mm, double end_stop_mm) : step_(step_mm), end_stop_(end_stop_mm) {}

  double stand(double target) {
    while (target - at() > step_ / 2) ++steps_;
    while (at() - target > step_ / 2) --steps_;
    nearest_tie_ = std::min(nearest_tie_, std::abs(std::abs(target - at()) - step_ / 2));
    return at();
  }
  double at() const { return end_stop_ + static_cast<double>(steps_) * step_; }
  /// How near a target was to halfway between two steps.
  double nearest_tie() const { return nearest_tie_; }

 private:
  double step_, end_stop_;
  std::int64_t steps_ = 0;
  double nearest_tie_ = 1;
};

struct WalkedPrint {
  double first = 0, thinnest = 1e9, thickest = 0, most_light = 0;
  double worst = 0;  ///< most that a layer is off, as a multiple of what is allowed
  bool doubtful = false;
};

/// The print as a list of heights and of times in the light, looked at in every way.
WalkedPrint walk(const PrintPlan& plan, double step_mm, double end_stop_mm) {
  WalkedPrint walked;
  WalkingStage stage(step_mm, end_stop_mm);
  std::vector<std::pair<double, double>> lit;
  double now = 0, below = 0;
  const auto go = [&](double to, Speed speed) {
    const double from = stage.at(), way = std::abs(stage.stand(to) - from);
    const double v = speed.value(), a = plan.acceleration.value();
    now += way * a > v * v ? way / v + v / a : 2 * std::sqrt(way / a);
  };
  const auto seconds = [](nanoseconds time) { return static_cast<double>(time.count()) * 1e-9; };
  const double layer = plan.layer_height.millimetres(), first = layer + plan.first_layer_more.millimetres();
  for (std::uint32_t k = 0; k < plan.layers; ++k) {
    const double target = first + k * layer;
    go(target + plan.retract2.millimetres(), plan.retract_speed);
    go(target, plan.retract_speed2);
    const double made = stage.at() - below, planned = k == 0 ? first : layer;
    below = stage.at();
    double allowed = 0.1 * planned;
    if (k == 0) allowed = std::min(std::max(allowed, step_mm / 2), planned / 2);
    walked.worst = std::max(walked.worst, std::abs(made - planned) / allowed);
    if (k == 0) {
      walked.first = made;
    } else {
      walked.thinnest = std::min(walked.thinnest, made);
      walked.thickest = std::max(walked.thickest, made);
    }
    now += seconds(plan.rest_before_exposure);
    lit.emplace_back(now, now + seconds(exposure_of(plan, k)));
    now = lit.back().second + seconds(plan.rest_after_exposure);
    go(target + plan.lift.millimetres(), plan.lift_speed);
    go(target + plan.lift.millimetres() + plan.lift2.millimetres(), plan.lift_speed2);
    now += seconds(plan.wait_after_lift);
  }
  for (const auto& last : lit) {
    double light = 0;
    for (const auto& one : lit) {
      light += std::max(0.0, std::min(one.second, last.second) - std::max(one.first, last.second - 60));
    }
    walked.most_light = std::max(walked.most_light, light);
  }
  walked.doubtful = stage.nearest_tie() < 2e-6 || std::abs(walked.worst - 1) < 1e-3;
  return walked;
}

TEST(PlanCheck, FindsWhatAStageThatWalksItsStepsWouldDo) {
  std::mt19937 random(7);
  const auto pick = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  int refused = 0, taken = 0;
  for (int round = 0; round < 600; ++round) {
    SCOPED_TRACE(round);
    const double steps[] = {0.02, 0.0125, 0.005, 0.0025, 0.00125, 0.0009375, 0.000625};
    const double step = steps[random() % std::size(steps)];
    const double end_stop = std::floor(pick(60, 180) * 1e4) / 1e4;
    PrintPlan plan = layers_of(std::floor(pick(0.005, 0.1) * 1e4) / 1e4, static_cast<std::uint32_t>(2 + random() % 60));
    plan.first_layer_more = Distance::millimetres(std::floor(pick(0, 0.1) * 1e4) / 1e4);
    plan.exposure = nanoseconds(static_cast<std::int64_t>(pick(0.5, 8) * 1e9));
    plan.initial_exposure = nanoseconds(static_cast<std::int64_t>(pick(0.5, 20) * 1e9));
    plan.wait_after_lift = nanoseconds(static_cast<std::int64_t>(pick(0, 5) * 1e9));
    plan.retract2 = Distance::millimetres(pick(0, 3));
    MachineFile machine = stage_of_steps(step, end_stop);
    machine.max_light_per_minute_s = 60;
    const WalkedPrint walked = walk(plan, step, end_stop);
    if (walked.doubtful) continue;
    const auto run = check_plan(plan, "part", machine);
    ASSERT_EQ(run.has_value(), walked.worst < 1)
        << step << " mm steps, " << plan.layer_height.millimetres() << " mm layers, off by " << walked.worst;
    if (!run) {
      EXPECT_EQ(run.error().code(), ErrorCode::kBadSetting);
      ++refused;
      continue;
    }
    ++taken;
    EXPECT_NEAR(run->first.millimetres(),
                std::max(walked.first, (plan.layer_height + plan.first_layer_more).millimetres()), 3e-6);
    EXPECT_NEAR(run->thinnest.millimetres(), std::min(walked.thinnest, plan.layer_height.millimetres()), 3e-6);
    EXPECT_NEAR(run->thickest.millimetres(), std::max(walked.thickest, plan.layer_height.millimetres()), 3e-6);
    EXPECT_NEAR(std::chrono::duration<double>(run->most_light).count(), walked.most_light, 1e-5);
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(taken, 100);
}

TEST(PlanCheck, RefusesTwoLayersAtOneHeightWithWhatWouldFit) {
  const auto refused = check_plan(layers_of(0.01, 200), "l01", stage_of_steps(0.02));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), ErrorCode::kBadSetting);
  EXPECT_THAT(refused.error().message(), AllOf(HasSubstr("l01: layer 0 would be 0.0200 mm high instead of 0.0100 mm"),
                                               HasSubstr("moves in steps of 0.0200 mm; its dose would be off by 100 %"),
                                               HasSubstr("such as 0.0200 mm")));
  EXPECT_EQ(to_string(refused.error().told().code), "stage_steps");
  EXPECT_TRUE(check_plan(layers_of(0.02, 200), "l01", stage_of_steps(0.02)));
}

TEST(PlanCheck, LooksAtTheSecondLayerOfAPlanWhoseLayersAreNotCountedYet) {
  // The first layer may stand half a step off, the second no more than a tenth of its height.
  EXPECT_FALSE(check_plan(layers_of(0.05, 1), "part", stage_of_steps(0.02)));
  EXPECT_TRUE(check_plan(layers_of(0.05, 1), "part", stage_of_steps(0.025)));
}

TEST(PlanCheck, CountsTheWorseOfTwoStepsThatAreEquallyNear) {
  // The end stop closes half a step off, so each layer lies halfway between two steps. All go the same way.
  const auto run = check_plan(layers_of(0.05, 300), "part", stage_of_steps(0.0025, 175.00125));
  ASSERT_TRUE(run) << run.error().message();
  EXPECT_EQ(run->thinnest, 50_um);
  EXPECT_EQ(run->thickest, 50_um);
  EXPECT_EQ(run->first, Distance::nanometres(51'250));
}

TEST(PlanCheck, LetsTheFirstLayerLieHalfAStepOffButNeverOnTheFilm) {
  PrintPlan plan = layers_of(0.02, 50);
  EXPECT_TRUE(check_plan(plan, "part", stage_of_steps(0.02, 175.009))) << "0.029 mm";
  plan.first_layer_more = Distance::millimetres(-0.013);
  const auto refused = check_plan(plan, "part", stage_of_steps(0.02));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("layer 0 would be 0.0000 mm high instead of 0.0070 mm"));
}

TEST(PlanCheck, RefusesMoreLightThanTheLampMayGive) {
  PrintPlan plan = layers_of(0.05, 100);
  MachineFile machine = stage_of_steps(0.00125);
  const auto run = check_plan(plan, "part", machine);
  ASSERT_TRUE(run);
  EXPECT_EQ(run->most_light, most_light_in_a_minute(plan)) << "whole steps: as the plan itself says";
  machine.max_light_per_minute_s = std::chrono::duration<double>(run->most_light).count() - 1e-3;
  const auto minute = check_plan(plan, "part", machine);
  ASSERT_FALSE(minute);
  EXPECT_EQ(minute.error().code(), ErrorCode::kExposureTooLong);
  EXPECT_THAT(minute.error().message(), HasSubstr("of light in a minute"));
  machine.max_light_per_minute_s = 60;
  machine.max_exposure_s = 29.9;
  const auto once = check_plan(plan, "part", machine);
  ASSERT_FALSE(once);
  EXPECT_THAT(once.error().message(),
              HasSubstr("part: 30.0 s of light at once, this printer's lamp may be lit for 29.9 s"));
}

TEST(PlanCheck, RefusesALiftAboveTheHighestPlace) {
  EXPECT_TRUE(check_plan(layers_of(0.05, 3340), "part", stage_of_steps(0.0025)));
  const auto refused = check_plan(layers_of(0.05, 3341), "part", stage_of_steps(0.0025));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), ErrorCode::kDoesNotFit);
  EXPECT_THAT(refused.error().message(), HasSubstr("ends at 174.05 mm, the Z stage goes up to 174.00 mm"));
}

TEST(PlanCheck, EveryBoardTakesTheProfilesThatComeWithIt) {
  for (const char* printer : {"mono2k", "mono4k", "mono8k", "sim2k", "pine64_ls055", "rpi4_dxq608"}) {
    const std::string path = std::string(PLUMBLINE_SOURCE_DIR "/board/") + printer + ".toml";
    const auto machine = *read_board_file(path).value().machine;
    for (const char* name : {"standard", "tough", "draft"}) {
      const auto profile = read_print_profile(name, path).value();
      const auto plan = plan_print(profile, machine, profile.layer_height, 1000);
      ASSERT_TRUE(plan) << name << " on " << printer << ": " << plan.error().message();
      const auto run = check_plan(*plan, name, machine);
      EXPECT_EQ(run->thinnest, run->thickest) << name << " on " << printer;
    }
  }
}

}  // namespace
}  // namespace plumbline::firmware
