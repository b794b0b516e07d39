/// Storage that loses its last writes after it has called them durable. What it keeps is a whole journal that ends too early: only the
/// height at which the power has left the stage tells. The print must go on at the right layer, or ask its user first.

#include "tests/hil/lying_storage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plumbline::firmware {
namespace {

using enum PrintState;
using ::testing::HasSubstr;

TEST(LyingStorage, WhateverItLosesThePrintGoesOnAtTheRightLayerOrItsUserIsAsked) {
  const Tally tally = lose_and_resume(300, 7);
  EXPECT_GT(tally.resumed, 10);
  EXPECT_GT(tally.confirmed, 5);
  EXPECT_GT(tally.given_up, 50);
  EXPECT_GT(tally.refused, 50);
}

TEST(LyingStorage, ThatLosesNothingIsBelievedWhereThePlateStandsStill) {
  Rig rig;
  const auto& whole = rig.run();
  ASSERT_EQ(whole.state, kFinished);
  // In the middle of each exposure.
  for (std::uint32_t layer = 0; layer < Rig::kLayers; ++layer) {
    const auto& light = rig.plant.lights()[layer];
    Rig cut(with_cut_at((light.began - TimePoint()) + (light.ended - light.began) / 2));
    ASSERT_EQ(cut.run().state, kSuspended);
    cut.plant.restore_power();
    EXPECT_EQ(cut.run().state, kFinished);
    EXPECT_TRUE(cut.user.questions.empty()) << layer << ": " << cut.user.questions[0];
  }
}

TEST(LyingStorage, APauseAndAShutdownLeaveNoDoubt) {
  for (const auto button : {EventKind::kPausePressed, EventKind::kShutdownRequested}) {
    Rig rig;
    rig.user.presses_start = false;
    rig.plant.timeline().at(TimePoint() + kPrint / 2, [&] { rig.plant.press(button); });
    if (button == EventKind::kPausePressed) {
      rig.plant.timeline().at(TimePoint() + kPrint, [&] { rig.plant.cut_power(); });
    }
    EXPECT_EQ(rig.run().state, kSuspended);
    if (!rig.plant.powered()) rig.plant.restore_power();
    rig.user.presses_start = true;
    EXPECT_EQ(rig.run().state, kFinished);
    EXPECT_TRUE(rig.user.questions.empty()) << rig.user.questions[0];
  }
}

TEST(LyingStorage, AQuestionThatNobodyHasAnsweredIsAskedAgain) {
  Rig rig(with_cut_at(kPrint / 2));
  ASSERT_EQ(rig.run().state, kSuspended);
  rig.storage.lose(10, [] { return true; });
  rig.plant.restore_power();
  rig.user.presses_start = false;
  rig.plant.timeline().at(rig.plant.now() + std::chrono::minutes(10), [&] { rig.plant.cut_power(); });
  EXPECT_EQ(rig.run().state, kSuspended);
  rig.plant.restore_power();
  rig.user.measures_part = true;
  EXPECT_EQ(rig.run().state, kCancelled);
  EXPECT_EQ(rig.objections_of(ObjectionKind::kTravelPastEnd), 0U);
  EXPECT_THAT(rig.user.questions.at(0), HasSubstr("Measure it: press start"));
}

/// Stopped in a layer, then cut off from power 13 layers later.
PlantSettings stopped_and_cut() {
  auto settings = rig_plant();
  for (const char* fault : {"system.shutdown@layer=12+0.5s", "power.cut@layer=25+0.5s"}) {
    settings.faults.push_back(parse_fault(fault).value());
  }
  return settings;
}

/// Prints with these settings on a medium that forgets what came after the stop. Its last record says how much light layer 12 has had.
/// The user is asked, and the system is shut down instead of an answer: the plate is raised.
void leave_unanswered(Rig& rig) {
  ASSERT_EQ(rig.run().state, kSuspended);
  ASSERT_GT(Journal::open(rig.storage)->last().lit, nanoseconds::zero());
  const std::size_t kept = rig.storage.writes();
  ASSERT_EQ(rig.run().state, kSuspended);
  ASSERT_TRUE(rig.user.questions.empty());
  rig.storage.lose(rig.storage.writes() - kept, [] { return true; });
  rig.plant.restore_power();
  rig.user.presses_start = false;
  rig.plant.timeline().at(rig.plant.now() + std::chrono::minutes(10),
                          [&] { rig.plant.press(EventKind::kShutdownRequested); });
  ASSERT_EQ(rig.run().state, kSuspended);
  ASSERT_EQ(rig.user.questions.size(), 1U);
}

void expect_the_question_again(Rig& rig) {
  rig.user.questions.clear();
  rig.user.presses_start = true;
  rig.user.measures_part = true;
  EXPECT_EQ(rig.run().state, kCancelled);
  EXPECT_EQ(rig.user.questions.size(), 1U);
  EXPECT_EQ(rig.objections_of(ObjectionKind::kTravelPastEnd), 0U);
}

TEST(LyingStorage, AShutdownIsNoAnswer) {
  Rig rig(stopped_and_cut());
  leave_unanswered(rig);
  expect_the_question_again(rig);
}

TEST(LyingStorage, AStartThatFailsItsChecksIsNoAnswer) {
  Rig rig(stopped_and_cut());
  leave_unanswered(rig);
  rig.same_process = true;  // the stage is homed already, high above the part
  rig.plant.inject(parse_fault("temperature.resin_sensor_dead@t=0s,for=30s").value());
  rig.plant.wait(std::chrono::seconds(1));
  ASSERT_EQ(rig.run().fault, FaultCode::kSensorDead);
  rig.plant.wait(std::chrono::minutes(1));
  rig.same_process = false;
  expect_the_question_again(rig);
}

TEST(LyingStorage, ACoverOpenedAsTheHomingEndsIsNoAnswer) {
  Rig rig(with_cut_at(kPrint / 2));
  ASSERT_EQ(rig.run().state, kSuspended);
  rig.storage.lose(10, [] { return true; });
  rig.plant.restore_power();
  // The stage is at rest, but the print has not noticed it.
  rig.plant.stage().on_leg = [&, before = rig.plant.stage().on_leg](const StageModel::Leg& leg) {
    before(leg);
    if (leg.to < 173.9_mm || leg.to > 174.1_mm) return;  // the homing's last leg
    rig.plant.open_cover();
    rig.plant.timeline().at(rig.plant.now() + std::chrono::minutes(1), [&] { rig.plant.close_cover(); });
  };
  rig.user.measures_part = true;
  EXPECT_EQ(rig.run().state, kCancelled);
  EXPECT_EQ(rig.user.questions.size(), 1U);
  EXPECT_EQ(rig.objections_of(ObjectionKind::kTravelPastEnd), 0U);
}

TEST(LyingStorage, ThatDropsItsWritesDuringAPrintEndsIt) {
  Rig rig;
  rig.plant.timeline().at(TimePoint() + kPrint / 2, [&] { rig.storage.drops = true; });
  const auto& report = rig.run();
  EXPECT_EQ(report.state, kFault);
  EXPECT_EQ(report.fault, FaultCode::kCannotWrite);
  EXPECT_THAT(report.fault_message.c_str(), HasSubstr("did not keep"));
  EXPECT_FALSE(rig.plant.light());
}

}  // namespace
}  // namespace plumbline::firmware
