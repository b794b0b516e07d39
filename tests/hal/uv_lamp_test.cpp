/// Contract of every back end: the lamp.

#include <gmock/gmock.h>

#include "hal/await.hpp"
#include "tests/hal/contract.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

using LampContract = Contract;

TEST_P(LampContract, LampIsLitForTheRequestedTime) {
  const Machine machine = rig_->machine();
  show_a_mask();
  for (const nanoseconds cure : {100ms, 650ms, 1ms, 37ms}) {
    const nanoseconds before = rig_->time_lit();
    const auto report = machine.lamp.expose(cure);
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_EQ(report->asked, cure);
    EXPECT_EQ(report->end, ExposureEnd::kTimeUp);
    EXPECT_LE(std::chrono::abs(report->lit - cure), 1ms);
    EXPECT_LE(std::chrono::abs(rig_->time_lit() - before - cure), 2ms);
    EXPECT_FALSE(rig_->light());
    // The promised 1 ms, and 1 %.
    const Irradiance irradiance = machine.lamp.limits().irradiance;
    const double dose = dose_of(irradiance, cure).value();
    EXPECT_NEAR(report->dose.value(), dose, dose_of(irradiance, 1ms).value() + 0.01 * dose);
  }
}

TEST_P(LampContract, LampGoesOffByItselfWhileTheFirmwareComputes) {
  const Machine machine = rig_->machine();
  show_a_mask();
  auto exposure = machine.lamp.begin_exposure(200ms);
  ASSERT_TRUE(exposure);
  EXPECT_TRUE(rig_->light());
  EXPECT_FALSE(exposure->over());
  EXPECT_EQ(exposure->ends_by() - exposure->began_at(), 200ms);
  ASSERT_TRUE(machine.clock.sleep_until(exposure->began_at() + 1s));
  EXPECT_TRUE(exposure->over());
  EXPECT_FALSE(rig_->light());
  const auto report = exposure->finish();
  ASSERT_TRUE(report);
  EXPECT_LE(std::chrono::abs(report->lit - 200ms), 1ms);
}

TEST_P(LampContract, EndOfAnExposureIsAnEvent) {
  const Machine machine = rig_->machine();
  show_a_mask();
  auto exposure = machine.lamp.begin_exposure(200ms);
  ASSERT_TRUE(exposure);
  EXPECT_THAT(events_in(500ms), testing::ElementsAre(EventKind::kExposureEnded));
}

TEST_P(LampContract, ExposureFinishedEarlyReportsHowMuchIsMissing) {
  const Machine machine = rig_->machine();
  show_a_mask();
  rig_->press(EventKind::kPausePressed, 300ms);
  auto exposure = machine.lamp.begin_exposure(2s);
  ASSERT_TRUE(exposure);
  const auto over = await(*exposure, machine.events, machine.clock, [](const Event&) { return Waiting::kReturn; });
  ASSERT_TRUE(over);
  EXPECT_FALSE(*over);
  const auto report = exposure->finish();
  ASSERT_TRUE(report);
  EXPECT_EQ(report->end, ExposureEnd::kStopped);
  EXPECT_NEAR(std::chrono::duration<double>(report->lit).count(), 0.3, 0.01);
  EXPECT_FALSE(rig_->light());
}

TEST_P(LampContract, LampGoesOffWhenItsExposureGoesOutOfScope) {
  const Machine machine = rig_->machine();
  show_a_mask();
  {
    const auto exposure = machine.lamp.begin_exposure(10s);
    ASSERT_TRUE(exposure);
    EXPECT_TRUE(machine.lamp.lit());
  }
  ASSERT_TRUE(machine.clock.sleep_until(machine.clock.now() + 5ms));
  EXPECT_FALSE(rig_->light());
  EXPECT_FALSE(machine.lamp.lit());
}

TEST_P(LampContract, LampIsOffTenMillisecondsAfterTheCoverOpensEvenIfTheFirmwareIsBusy) {
  const Machine machine = rig_->machine();
  show_a_mask();
  rig_->open_cover(300ms);
  auto exposure = machine.lamp.begin_exposure(5s);
  ASSERT_TRUE(exposure);
  const TimePoint start = exposure->began_at();
  ASSERT_TRUE(machine.clock.sleep_until(start + 310ms));  // computes
  EXPECT_FALSE(rig_->light());
  EXPECT_TRUE(exposure->over());
  EXPECT_THAT(events_in(100ms), testing::ElementsAre(EventKind::kCoverOpened, EventKind::kExposureEnded));
  const auto report = exposure->finish();
  ASSERT_TRUE(report);
  EXPECT_EQ(report->end, ExposureEnd::kCoverOpened);
  EXPECT_GE(report->lit, 300ms);
  EXPECT_LE(report->lit, 310ms);
  EXPECT_TRUE(failed_with(machine.lamp.begin_exposure(1s), ErrorCode::kCoverOpen));
  rig_->close_cover(0ms);
  EXPECT_THAT(events_in(100ms), testing::ElementsAre(EventKind::kCoverClosed));
  EXPECT_TRUE(machine.lamp.begin_exposure(1s));
}

TEST_P(LampContract, LampRefusesUnsafeExposures) {
  const Machine machine = rig_->machine();
  EXPECT_TRUE(failed_with(machine.lamp.begin_exposure(1s), ErrorCode::kMaskNotPresented));
  show_a_mask();
  EXPECT_TRUE(failed_with(machine.lamp.begin_exposure(machine.lamp.limits().longest_exposure + 1ns),
                          ErrorCode::kExposureTooLong));
  EXPECT_TRUE(failed_with(machine.lamp.begin_exposure(0ns), ErrorCode::kBadSetting));
  EXPECT_TRUE(failed_with(machine.lamp.begin_exposure(-1s), ErrorCode::kBadSetting));
  {
    const auto exposure = machine.lamp.begin_exposure(1s);
    ASSERT_TRUE(exposure);
    EXPECT_TRUE(failed_with(machine.lamp.begin_exposure(1s), ErrorCode::kBusy));
  }
  ASSERT_TRUE(machine.clock.sleep_until(machine.clock.now() + 20ms));
  {
    const auto motion = machine.stage.begin_homing();
    ASSERT_TRUE(motion);
    EXPECT_TRUE(failed_with(machine.lamp.begin_exposure(1s), ErrorCode::kStageMoving));
  }
  ASSERT_TRUE(machine.mask.blank());
  const nanoseconds before = rig_->time_lit();
  EXPECT_TRUE(failed_with(machine.lamp.begin_exposure(1s), ErrorCode::kMaskNotPresented));
  ASSERT_TRUE(machine.clock.sleep_until(machine.clock.now() + 100ms));
  EXPECT_EQ(rig_->time_lit(), before);
}

INSTANTIATE_TEST_SUITE_P(Hal, LampContract, testing::ValuesIn(rig_makers()), kRigName);

}  // namespace
}  // namespace plumbline
