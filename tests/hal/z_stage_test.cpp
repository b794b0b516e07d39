/// Contract of every back end: the stage.

#include <gmock/gmock.h>

#include "hal/await.hpp"
#include "hal/ramp.hpp"
#include "tests/hal/contract.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

using StageContract = Contract;

TEST_P(StageContract, StageKnowsItsHeightOnceHomed) {
  ZStage& stage = rig_->machine().stage;
  EXPECT_FALSE(stage.homed());
  EXPECT_TRUE(failed_with(stage.position(), ErrorCode::kNotHomed));
  EXPECT_TRUE(failed_with(stage.begin_move(stage.limits().highest, Speed(1)), ErrorCode::kNotHomed));
  home();
  EXPECT_TRUE(stage.homed());
  const auto position = stage.position();
  ASSERT_TRUE(position);
  EXPECT_LE(stage.limits().highest - *position, 5_um);
  EXPECT_NEAR(rig_->plate_height().micrometres(), position->above_film().micrometres(), 5);
  EXPECT_FALSE(stage.end_stop_pressed());
}

TEST_P(StageContract, HomingTellsWhereItBegan) {
  ZStage& stage = rig_->machine().stage;
  for (const Distance from : {rig_->plate_height(), 150_mm, 12_mm}) {
    if (stage.homed()) {
      ASSERT_TRUE(stage.move_to(ZPosition(from), Speed(10)));
    }
    const auto homed = stage.home();
    ASSERT_TRUE(homed) << homed.error().message();
    ASSERT_TRUE(homed->began_at_height);
    EXPECT_NEAR(homed->began_at_height->above_film().micrometres(), from.micrometres(), 5);
  }
  EXPECT_FALSE(stage.move_to(ZPosition(160_mm), Speed(10))->began_at_height);
}

TEST_P(StageContract, MoveArrivesInTheTimeOfItsRamp) {
  const Machine machine = rig_->machine();
  home();
  for (const auto& [height, speed] :
       {std::pair{160_mm, 5.0}, {159.95_mm, 5.0}, {165_mm, 1.0}, {100_um, 10.0}, {0_um, 1.0}}) {
    const ZPosition from = machine.stage.position().value();
    const Distance way = ZPosition(height) - from;
    const Ramp ramp(way < Distance() ? -way : way, Speed(speed), machine.stage.limits().acceleration);
    const auto moved = machine.stage.move_to(ZPosition(height), Speed(speed));
    ASSERT_TRUE(moved) << moved.error().message();
    EXPECT_TRUE(moved->arrived);
    EXPECT_NEAR(std::chrono::duration<double>(moved->ended_at - moved->began_at).count(), ramp.duration().count(),
                0.005);
    EXPECT_NEAR(moved->position.above_film().micrometres(), height.micrometres(), 1);
    EXPECT_NEAR(rig_->plate_height().micrometres(), height.micrometres(), 5);
    EXPECT_EQ(moved->steps_lost, Distance());
  }
}

TEST_P(StageContract, StageTakesNoStepBeyondItsTravel) {
  const Machine machine = rig_->machine();
  home();
  const Distance before = rig_->plate_height();
  const auto& limits = machine.stage.limits();
  EXPECT_TRUE(failed_with(machine.stage.begin_move(limits.lowest - 1_um, Speed(1)), ErrorCode::kOutsideTravel));
  EXPECT_TRUE(failed_with(machine.stage.begin_move(limits.highest + 1_um, Speed(1)), ErrorCode::kOutsideTravel));
  EXPECT_TRUE(failed_with(machine.stage.begin_move(limits.lowest, Speed(0)), ErrorCode::kBadSetting));
  EXPECT_TRUE(failed_with(machine.stage.begin_move(limits.lowest, Speed(-1)), ErrorCode::kBadSetting));
  EXPECT_TRUE(failed_with(machine.stage.begin_move(limits.lowest, limits.fastest * 1.001), ErrorCode::kBadSetting));
  EXPECT_TRUE(failed_with(machine.stage.begin_move(limits.lowest, Speed(std::nan(""))), ErrorCode::kBadSetting));
  ASSERT_TRUE(machine.clock.sleep_until(machine.clock.now() + 50ms));
  EXPECT_EQ(rig_->plate_height(), before);
}

TEST_P(StageContract, StageDoesNotMoveUnderLight) {
  const Machine machine = rig_->machine();
  home();
  show_a_mask();
  const auto exposure = machine.lamp.begin_exposure(1s);
  ASSERT_TRUE(exposure);
  EXPECT_TRUE(failed_with(machine.stage.begin_move(machine.stage.limits().lowest, Speed(1)), ErrorCode::kLampLit));
  EXPECT_TRUE(failed_with(machine.stage.begin_homing(), ErrorCode::kLampLit));
  EXPECT_FALSE(machine.stage.moving());
}

TEST_P(StageContract, StageKnowsItsHeightAfterAnEventStopsItsMotion) {
  const Machine machine = rig_->machine();
  home();
  rig_->press(EventKind::kCancelPressed, 1s);
  auto motion = machine.stage.begin_move(ZPosition(100_mm), Speed(5));
  ASSERT_TRUE(motion);
  const TimePoint planned = motion->ends_by();
  EXPECT_TRUE(failed_with(machine.stage.begin_move(ZPosition(50_mm), Speed(5)), ErrorCode::kBusy));
  const auto over = await(*motion, machine.events, machine.clock, [](const Event&) { return Waiting::kReturn; });
  ASSERT_TRUE(over);
  EXPECT_FALSE(*over);
  ASSERT_TRUE(motion->stop());
  EXPECT_LT(motion->ends_by(), planned);
  EXPECT_LE(motion->ends_by() - machine.clock.now(), 150ms);  // v / a = 0.1 s
  const auto report = motion->finish();
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->arrived);
  // 1 s at 5 mm/s, less half of the acceleration phase, plus half of the braking phase: 5 mm
  EXPECT_NEAR((machine.stage.limits().highest - report->position).millimetres(), 5.0, 0.1);
  EXPECT_NEAR(rig_->plate_height().micrometres(), report->position.above_film().micrometres(), 5);
  EXPECT_EQ(machine.stage.position().value(), report->position);
}

TEST_P(StageContract, StageStopsWhenItsMotionGoesOutOfScope) {
  const Machine machine = rig_->machine();
  home();
  {
    const auto motion = machine.stage.begin_move(ZPosition(10_mm), Speed(5));
    ASSERT_TRUE(motion);
    ASSERT_TRUE(machine.clock.sleep_until(machine.clock.now() + 200ms));
    EXPECT_TRUE(machine.stage.moving());
  }
  EXPECT_FALSE(machine.stage.moving());
  const Distance height = rig_->plate_height();
  ASSERT_TRUE(machine.clock.sleep_until(machine.clock.now() + 200ms));
  EXPECT_EQ(rig_->plate_height(), height);
  EXPECT_TRUE(machine.stage.homed());
}

TEST_P(StageContract, StoppedHomingLeavesTheHeightUnknown) {
  const Machine machine = rig_->machine();
  auto motion = machine.stage.begin_homing();
  ASSERT_TRUE(motion);
  ASSERT_TRUE(machine.clock.sleep_until(machine.clock.now() + 200ms));
  ASSERT_TRUE(motion->stop());
  const auto report = motion->finish();
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->arrived);
  EXPECT_FALSE(machine.stage.homed());
  home();
  EXPECT_TRUE(machine.stage.homed());
}

TEST_P(StageContract, JogsAShortWayWithoutBeingHomed) {
  const Machine machine = rig_->machine();
  const Distance before = rig_->plate_height();
  for (const Distance way : {2_mm, -5_mm}) {
    auto jog = machine.stage.begin_jog(way);
    ASSERT_TRUE(jog) << jog.error().message();
    const auto report = jog->finish();
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_TRUE(report->arrived);
  }
  EXPECT_NEAR((rig_->plate_height() - before).micrometres(), -3000, 5);
  EXPECT_FALSE(machine.stage.homed());
  for (const Distance far : {0_mm, 10_mm + 1_um, -10_mm - 1_um}) {
    EXPECT_TRUE(failed_with(machine.stage.begin_jog(far), ErrorCode::kOutsideTravel));
  }
  EXPECT_TRUE(machine.stage.begin_jog(10_mm)->finish());
  home();
  EXPECT_TRUE(machine.stage.begin_jog(-1_mm)->finish());
  EXPECT_FALSE(machine.stage.homed()) << "a jog knows no height";
}

TEST_P(StageContract, AJogEndsAtTheEndStopAndDoesNotBeginThere) {
  const Machine machine = rig_->machine();
  home();
  auto jog = machine.stage.begin_jog(10_mm);  // the end stop is 2 mm above
  ASSERT_TRUE(jog);
  const auto report = jog->finish();
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_FALSE(report->arrived);
  EXPECT_TRUE(machine.stage.end_stop_pressed());
  EXPECT_LT(rig_->plate_height() - machine.stage.limits().end_stop.above_film(), 100_um);
  EXPECT_TRUE(failed_with(machine.stage.begin_jog(1_mm), ErrorCode::kEndStopStuck));
  EXPECT_TRUE(failed_with(machine.stage.begin_jog(-1_mm), ErrorCode::kEndStopStuck));
}

TEST_P(StageContract, AJogIsStoppedByAButtonAndRefusedUnderLight) {
  const Machine machine = rig_->machine();
  const Distance before = rig_->plate_height();
  rig_->press(EventKind::kCancelPressed, 1s);
  auto jog = machine.stage.begin_jog(10_mm);
  ASSERT_TRUE(jog);
  const auto over = await(*jog, machine.events, machine.clock, [](const Event&) { return Waiting::kReturn; });
  ASSERT_TRUE(over);
  EXPECT_FALSE(*over);
  ASSERT_TRUE(jog->stop());
  EXPECT_FALSE(jog->finish()->arrived);
  EXPECT_NEAR((rig_->plate_height() - before).millimetres(), 1.0, 0.1);  // at 1 mm/s
  home();
  show_a_mask();
  const auto exposure = machine.lamp.begin_exposure(1s);
  ASSERT_TRUE(exposure);
  EXPECT_TRUE(failed_with(machine.stage.begin_jog(1_mm), ErrorCode::kLampLit));
}

TEST_P(StageContract, EndOfAMotionIsAnEvent) {
  home();
  auto motion = rig_->machine().stage.begin_move(ZPosition(165_mm), Speed(5));
  ASSERT_TRUE(motion);
  EXPECT_THAT(events_in(3s), testing::ElementsAre(EventKind::kMotionEnded));
  EXPECT_TRUE(motion->over());
}

INSTANTIATE_TEST_SUITE_P(Hal, StageContract, testing::ValuesIn(rig_makers()), kRigName);

}  // namespace
}  // namespace plumbline
