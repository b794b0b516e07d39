/// What a print asks of the tank, and what the printer's record says of it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/firmware/support/job_fixture.hpp"
#include "tests/hil/rig.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using enum PrintState;

/// Of the rig's whole print, with nothing for the hole: no more than it takes.
double all_ml() { return 40 * 42 * 40 * resin_ml(1, kRigPitchMm, kRigPitchMm, 0.05); }

std::size_t times(const Rig& rig, PrintState state) {
  return static_cast<std::size_t>(std::count(rig.user.states.begin(), rig.user.states.end(), state));
}

TEST(Tank, IsAskedAboutBeforeASecondPrintThatNeedsMoreThanTheFirstHasLeft) {
  Rig rig;
  rig.give_tank(1.3 * all_ml());
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_EQ(times(rig, kFeedMe), 0U);
  const double left = *rig.record.resin_ml();
  EXPECT_LT(left, 0.4 * all_ml());

  rig.begin_anew();
  rig.user.states.clear();
  std::size_t lights_when_asked = 1;
  rig.user.on_update = [&](const PrintStatus& status) {
    if (status.state == kFeedMe) lights_when_asked = rig.plant.lights().size();
  };
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_THAT(rig.user.states, ElementsAre(kChecks, kHoming, kPrinting, kFeedMe, kPrinting, kFinishing, kFinished));
  EXPECT_EQ(lights_when_asked, 0U) << "before any light";
  EXPECT_EQ(rig.user.checks[static_cast<std::size_t>(Check::kResin)], CheckOutcome::kWarned);
  ASSERT_EQ(rig.user.questions.size(), 1U);
  EXPECT_THAT(rig.user.questions[0], HasSubstr("fill the tank to "));
}

TEST(Tank, IsAskedAboutAgainWhenThePowerWentWhileItWasEmpty) {
  auto settings = rig_plant();
  Rig rig(settings);
  rig.give_tank(all_ml() / 2);
  rig.user.on_update = [&](const PrintStatus& status) {
    if (status.state == kFeedMe && rig.plant.powered()) rig.plant.cut_power();
  };
  EXPECT_EQ(rig.run().state, kSuspended);
  rig.plant.restore_power();
  rig.user.on_update = [&](const PrintStatus& status) {
    if (status.state == kFeedMe) rig.plant.press(EventKind::kCancelPressed);
  };
  rig.user.states.clear();
  const std::size_t lit = rig.plant.lights().size();
  const PrintReport& report = rig.run();
  EXPECT_EQ(report.state, kCancelled) << "there is no more resin";
  EXPECT_EQ(times(rig, kFeedMe), 1U);
  EXPECT_EQ(rig.plant.lights().size(), lit) << "nothing is cured on an empty tank";
}

TEST(Tank, ThatNobodyHasSpokenOfIsAskedAboutFirst) {
  const TemporaryFolder folder;
  Rig rig;
  rig.record = MachineRecord::open(folder / ".", rig.tank_ml).value();
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_THAT(rig.user.states, ElementsAre(kChecks, kHoming, kPrinting, kFeedMe, kPrinting, kFinishing, kFinished));
  ASSERT_EQ(rig.user.questions.size(), 1U);
  EXPECT_THAT(rig.user.questions[0], HasSubstr("nobody has said how much resin there is: fill the tank to 9.1 ml"));
  ASSERT_TRUE(rig.record.resin_ml());
  EXPECT_NEAR(*rig.record.resin_ml(), 9.1 - rig.plant_ml(), 1e-9) << "what was asked for counts, not a full tank";
}

TEST(Tank, HoldsWhatAPersonSaysInsteadOfWhatWasAskedFor) {
  const TemporaryFolder folder;
  Rig rig;
  rig.record = MachineRecord::open(folder / ".", rig.tank_ml).value();
  rig.user.on_update = [&](const PrintStatus& status) {
    if (status.state == kFeedMe && !rig.record.resin_ml()) {
      ASSERT_TRUE(rig.record.fill(120));
    }
  };
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_NEAR(*rig.record.resin_ml(), 120 - rig.plant_ml(), 1e-9);
}

TEST(Tank, CountsALayerThatWasLitWhenThePrintWasCancelled) {
  Rig rig;
  rig.plant.inject(parse_fault("button.cancel@layer=20+1s").value());
  const PrintReport& report = rig.run();
  EXPECT_EQ(report.state, kCancelled);
  EXPECT_EQ(report.next_layer, 20U);
  EXPECT_NEAR(*rig.record.resin_ml(), rig.tank_ml - rig.plant_ml(), 1e-9);
  EXPECT_EQ(rig.record.film_layers(), 20U);
  EXPECT_GT(rig.record.lamp_lit(), std::chrono::seconds(50));
}

TEST(Waiting, ForResinThatIsATenthTooColdForAMinuteIsAPauseAndNoFault) {
  auto settings = rig_plant();
  settings.faults.push_back(parse_fault("temperature.resin_cold@layer=10,for=60s,by=17.9").value());
  Rig rig(settings);
  rig.user.presses_start = false;
  const PrintReport& report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(report.state, kFinished) << report.fault_message.c_str();
  EXPECT_THAT(rig.user.states,
              ElementsAre(kChecks, kHoming, kPrinting, kCoolingDown, kPrinting, kFinishing, kFinished));
  ASSERT_EQ(rig.user.questions.size(), 1U);
  EXPECT_EQ(rig.user.questions[0],
            "PL-603, resin too cold: the resin is at 17.9 degrees C, 18 to 40 allowed. The print goes on by itself");
  EXPECT_EQ(rig.objections(), "");
}

TEST(Waiting, GoesOnByItselfForEachSensorAndFan) {
  for (const char* fault : {"temperature.lamp_hot", "temperature.resin_cold", "temperature.resin_hot",
                            "temperature.board_hot", "fan.lamp_stalls", "fan.chamber_stalls"}) {
    SCOPED_TRACE(fault);
    auto settings = rig_plant();
    settings.faults.push_back(parse_fault(std::string(fault) + "@layer=10,for=600s").value());
    Rig rig(settings);
    rig.user.presses_start = false;
    EXPECT_EQ(rig.run().state, kFinished);
    EXPECT_EQ(times(rig, kCoolingDown), 1U);
  }
}

TEST(Waiting, DoesNotStartAndStopAtTheLimit) {
  Rig rig;
  rig.user.presses_start = false;
  // Half a degree below and above its limit, every five seconds, for ten minutes.
  bool cold = false;
  std::function<void()> swing = [&] {
    auto& forced = rig.plant.thermals().forced[static_cast<std::size_t>(TemperatureSite::kResin)];
    cold = !cold;
    forced =
        rig.plant.now() < TimePoint() + std::chrono::minutes(12) ? std::optional(cold ? 17.8 : 18.2) : std::nullopt;
    if (forced) rig.plant.timeline().at(rig.plant.now() + std::chrono::seconds(5), swing);
  };
  rig.plant.timeline().at(TimePoint() + std::chrono::minutes(2), swing);
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_EQ(times(rig, kCoolingDown), 1U);
}

TEST(Waiting, AsksAPersonAfterAnHour) {
  auto settings = rig_plant();
  settings.faults.push_back(parse_fault("fan.chamber_stalls@layer=10,for=9000s").value());
  Rig rig(settings);
  rig.user.gives_up_after = std::chrono::hours(2);
  const PrintReport& report = rig.run();
  EXPECT_EQ(report.state, kFinished);
  EXPECT_THAT(rig.user.states, ElementsAre(kChecks, kHoming, kPrinting, kCoolingDown, kPaused, kPrinting, kCoolingDown,
                                           kPaused, kPrinting, kCoolingDown, kPrinting, kFinishing, kFinished));
  ASSERT_GE(rig.user.questions.size(), 2U);
  EXPECT_THAT(rig.user.questions[0], HasSubstr("PL-607, chamber fan stalled"));
  EXPECT_THAT(rig.user.questions[1], HasSubstr("for an hour: press start to wait again, or cancel"));
}

TEST(Waiting, BeginsBeforeThePrintIfItMust) {
  auto settings = rig_plant();
  settings.faults.push_back(parse_fault("temperature.resin_cold@t=0s,for=900s,by=12").value());
  Rig rig(settings);
  rig.plant.wait(std::chrono::milliseconds(1));
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_THAT(rig.user.failed_checks, IsEmpty());
  EXPECT_EQ(rig.user.checks[static_cast<std::size_t>(Check::kTemperatures)], CheckOutcome::kWarned);
  EXPECT_THAT(rig.user.states,
              ElementsAre(kChecks, kHoming, kPrinting, kCoolingDown, kPrinting, kFinishing, kFinished));
}

TEST(Waiting, RemembersTheHighestTemperatures) {
  auto settings = rig_plant();
  settings.faults.push_back(parse_fault("temperature.board_hot@layer=10,for=60s").value());
  Rig rig(settings);
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_EQ(rig.record.hottest(TemperatureSite::kBoard), Celsius(105));
  EXPECT_EQ(rig.record.hottest(TemperatureSite::kResin), Celsius(25));
}

/// Whether a fan is on: one that can't turn is noticed only then.
bool is_on(Rig& rig, Fan fan) {
  rig.plant.thermals().set_stalled(rig.plant.now(), fan, true);
  return rig.plant.thermals().fan_health(fan) == FanHealth::kStalled;
}

TEST(LampFan, StopsWithThePrint) {
  Rig rig;
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_FALSE(is_on(rig, Fan::kLamp));
  EXPECT_FALSE(is_on(rig, Fan::kChamber));
}

TEST(LampFan, RunsOnWhileTheLampIsStuckOn) {
  for (const char* when : {"lamp.runaway@t=0s", "lamp.runaway@layer=5", "lamp.stuck_on@layer=5"}) {
    SCOPED_TRACE(when);
    auto settings = rig_plant();
    settings.faults.push_back(parse_fault(when).value());
    Rig rig(settings);
    rig.plant.wait(std::chrono::milliseconds(10));
    EXPECT_EQ(rig.run().fault, FaultCode::kLampStuckOn);
    EXPECT_TRUE(is_on(rig, Fan::kLamp));
  }
}

}  // namespace
}  // namespace plumbline::firmware
