/// Whole prints of the real firmware on the plant.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hil/rig.hpp"

namespace plumbline::firmware {
namespace {

using namespace plumbline::literals;
using namespace std::chrono_literals;
using ::testing::ElementsAre;
using enum PrintState;

PlantSettings with_fault(const std::string& text) {
  auto settings = rig_plant();
  settings.faults.push_back(parse_fault(text).value());
  return settings;
}

/// The part of an undisturbed print, from the formula.
std::vector<std::vector<std::uint64_t>> whole_part(std::uint32_t layers = Rig::kLayers) {
  std::vector<std::vector<std::uint64_t>> part;
  for (std::uint32_t layer = 0; layer < layers; ++layer) {
    std::vector<std::uint64_t> words(BitImage::words_needed(kRigColumns, kRigRows));
    const BitImage image(words, kRigColumns, kRigRows);
    for (std::uint32_t y = 0; y < kRigRows; ++y) {
      for (std::uint32_t x = 0; x < kRigColumns; ++x) {
        if (in_tower(x, y, layer)) image.set(x, y);
      }
    }
    part.push_back(words);
  }
  return part;
}

TEST(Print, MakesThePartAskedForWithoutObjections) {
  Rig rig;
  const auto& report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(report.state, kFinished) << report.fault_message.c_str();
  EXPECT_THAT(rig.user.states, ElementsAre(kChecks, kHoming, kPrinting, kFinishing, kFinished));
  EXPECT_EQ(rig.objections(), "");
  EXPECT_EQ(rig.part(), whole_part());
  EXPECT_EQ(report.next_layer, Rig::kLayers);
  EXPECT_EQ(report.late_masks, 0U);
  EXPECT_FALSE(report.marked_layer);
}

TEST(Print, GivesEveryLayerItsDoseAtItsHeight) {
  Rig rig;
  const auto& report = rig.run();
  const auto layers = rig.plant.part().layers();
  ASSERT_EQ(layers.size(), Rig::kLayers);
  ASSERT_EQ(report.exposures.size(), Rig::kLayers);
  for (std::uint32_t layer = 0; layer < Rig::kLayers; ++layer) {
    EXPECT_EQ(layers[layer].z, height_of(rig.plan, layer)) << layer;
    const Dose asked = dose_of(Irradiance(3.5), exposure_of(rig.plan, layer));
    EXPECT_NEAR(layers[layer].dose.value(), asked.value(), 1e-3 * asked.value()) << layer;
    EXPECT_EQ(report.exposures[layer].asked, exposure_of(rig.plan, layer));
    EXPECT_NEAR(report.exposures[layer].dose.value(), layers[layer].dose.value(), 1e-9);
  }
}

TEST(Print, TakesAsLongAsThePlanSays) {
  Rig rig;
  const auto& report = rig.run();
  const double planned = std::chrono::duration<double>(report.estimated).count();
  const double took = std::chrono::duration<double>(report.elapsed).count();
  EXPECT_GT(took, planned) << "homing is added";
  EXPECT_LT(took - planned, 80) << "to the end stop and back, twice";
}

/// What was told of the time left, against the time that was left, s.
struct TimeLeft {
  double most_off = 0;      ///< once the end stop was found
  double before_homed = 0;  ///< the same, until then
  int rises = 0;            ///< but for those that a pause explains
};
TimeLeft time_left(const std::vector<PrintStatus>& updates) {
  TimeLeft found;
  const auto seconds = [](nanoseconds time) { return std::chrono::duration<double>(time).count(); };
  bool paused = false;
  for (std::size_t i = 0; i < updates.size(); ++i) {
    const PrintStatus& told = updates[i];
    paused = paused || is_pause(told.state);
    if (i > 0 && told.remaining > updates[i - 1].remaining && !paused) ++found.rises;
    if (is_pause(told.state)) continue;
    paused = false;
    // Pauses that are still to come are not foreseen.
    const bool undisturbed = std::none_of(updates.begin() + static_cast<std::ptrdiff_t>(i), updates.end(),
                                          [](const PrintStatus& later) { return is_pause(later.state); });
    if (!undisturbed) continue;
    const double off = std::abs(seconds(told.remaining) - seconds(updates.back().now - told.now));
    const bool homed = told.state != kChecks && told.state != kHoming;
    (homed ? found.most_off : found.before_homed) = std::max(off, homed ? found.most_off : found.before_homed);
  }
  return found;
}

// Regression: 479, 549 and then 583 s were left, and 0 s while the part was raised for 39 s.
TEST(Print, TimeLeftFallsToTheEndAndIsTrue) {
  for (const char* fault : {"", "button.pause@layer=20", "cover.opens@layer=12+1s,for=30s"}) {
    SCOPED_TRACE(fault);
    Rig rig(*fault == '\0' ? rig_plant() : with_fault(fault));
    EXPECT_EQ(rig.run().state, kFinished);
    const TimeLeft found = time_left(rig.user.updates);
    EXPECT_EQ(found.rises, 0);
    EXPECT_LT(found.most_off, 3) << "of some 500 s";
    EXPECT_LT(found.before_homed, 36) << "where the stage stands is not known yet: 175 mm at 5 mm/s";
    EXPECT_EQ(rig.user.updates.back().remaining, 0s);
    const auto raising = std::find_if(rig.user.updates.begin(), rig.user.updates.end(),
                                      [](const PrintStatus& told) { return told.state == kFinishing; });
    EXPECT_GT(raising->remaining, 30s) << "up 165 mm at 5 mm/s, and home";
  }
}

TEST(Print, SaysAtOnceThatItPausesAfterTheLayer) {
  Rig rig(with_fault("button.pause@layer=20+1s"));
  rig.run();
  const auto told = std::find_if(rig.user.updates.begin(), rig.user.updates.end(),
                                 [](const PrintStatus& status) { return status.note == PrintNote::kPauseTaken; });
  ASSERT_NE(told, rig.user.updates.end());
  EXPECT_EQ(told->state, kPrinting);
  const LightRecord& light = rig.plant.lights()[20];
  EXPECT_LT(told->now - light.began, 1100ms) << "the layer's light lasts for 2.5 s";
  EXPECT_LT(told->now, light.ended);
  const auto pausing =
      std::find_if(told, rig.user.updates.end(), [](const PrintStatus& status) { return status.state == kPausing; });
  ASSERT_NE(pausing, rig.user.updates.end());
  EXPECT_EQ(pausing->note, PrintNote::kNone);
}

// Regression: cancelled with the cover open, the plate moved where a hand could be.
TEST(Print, MovesNoPlateWhileTheCoverIsOpenEvenAtTheEnd) {
  auto settings = with_fault("cover.opens@layer=20+1s,for=40s");
  settings.faults.push_back(parse_fault("button.cancel@layer=20+10s").value());
  Rig rig(settings);
  std::optional<Distance> stood;
  bool told = false;
  rig.user.on_update = [&](const PrintStatus& status) {
    if (!rig.plant.cover_open()) return;
    if (stood) {
      EXPECT_EQ(rig.plant.stage().height(), *stood);
    }
    stood = rig.plant.stage().height();
    told = told || (status.state == kCancelling && status.note == PrintNote::kCoverFirst);
  };
  EXPECT_EQ(rig.run().state, kCancelled);
  EXPECT_TRUE(told);
  EXPECT_THAT(rig.user.states, ElementsAre(kChecks, kHoming, kPrinting, kCoverOpen, kCancelling, kCancelled));
  EXPECT_GT(rig.plant.stage().height(), 170_mm) << "the part is raised once the cover is closed";
}

TEST(Print, StopsTheLastRaiseWhileTheCoverIsOpen) {
  // The last layer's light ends some seconds before the raise begins.
  Rig rig(with_fault("cover.opens@layer=39+12s,for=30s"));
  std::optional<Distance> stood;
  rig.user.on_update = [&](const PrintStatus& status) {
    if (status.note != PrintNote::kCoverFirst) return;
    if (stood && status.now - rig.user.noted_at > 1s) {
      EXPECT_EQ(rig.plant.stage().height(), *stood);
    }
    stood = rig.plant.stage().height();
  };
  EXPECT_EQ(rig.run().state, kFinished);
  ASSERT_TRUE(stood) << "it opened while the part was raised";
  EXPECT_LT(*stood, 170_mm);
  EXPECT_GT(rig.plant.stage().height(), 170_mm);
}

TEST(Print, TakesNoStartThatWasPressedBeforeItWaited) {
  Rig rig(with_fault("button.pause@layer=20"));
  rig.user.presses_start = false;
  int pressed = 0;
  std::optional<TimePoint> paused_at;
  rig.user.on_update = [&](const PrintStatus& status) {
    if (status.state != kPaused || pressed == 2) return;
    if (!paused_at) paused_at = status.now;
    if (status.now - *paused_at < (pressed == 0 ? 400ms : 2000ms)) return;
    rig.plant.press(EventKind::kStartPressed);
    ++pressed;
  };
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_EQ(pressed, 2) << "the first press did nothing";
}

/// Looks at the stage every 5 ms. @returns when it moved, the first and the last look at each move
std::vector<std::pair<TimePoint, TimePoint>> moves_of(Rig& rig) {
  std::vector<std::pair<TimePoint, TimePoint>> moves;
  bool moving = false;
  const std::function<void()> look = [&] {
    const TimePoint now = rig.plant.now();
    if (rig.plant.stage().moving()) {
      if (!moving) moves.emplace_back(now, now);
      moves.back().second = now;
    }
    moving = rig.plant.stage().moving();
    rig.plant.timeline().at(now + 5ms, look);
  };
  rig.plant.timeline().at(rig.plant.now(), look);
  EXPECT_EQ(rig.run().state, kFinished);
  return moves;
}

// Light and motion each expect the other's absence; the panel is black whenever the stage moves, so that a lamp that leaks cures nothing.
TEST(Print, MovesOnlyUnderABlackPanelAndAfterTheJournalHasTheLayer) {
  Rig rig(rig_plant(), 6);
  std::size_t looks = 0;
  bool moving = false;
  const std::function<void()> look = [&] {
    if (rig.plant.stage().moving()) {
      ++looks;
      EXPECT_TRUE(rig.plant.panel().black());
      EXPECT_FALSE(rig.plant.light());
      // As it begins to move away from a cured layer.
      if (!std::exchange(moving, true) && !rig.plant.lights().empty()) {
        EXPECT_EQ(Journal::open(rig.storage)->last().next_layer, rig.plant.lights().back().layer + 1);
      }
    }
    moving = rig.plant.stage().moving();
    rig.plant.timeline().at(rig.plant.now() + 5ms, look);
  };
  rig.plant.timeline().at(rig.plant.now(), look);
  EXPECT_EQ(rig.run().state, kFinished);
  EXPECT_GT(looks, 1000U);
}

TEST(Print, RestsBeforeAndAfterEachExposureAsThePlanSays) {
  Rig rig(rig_plant(), 6);
  rig.plan.rest_before_exposure = 3s;
  rig.plan.rest_after_exposure = 2s;
  const auto moves = moves_of(rig);
  ASSERT_EQ(rig.plant.lights().size(), 6U);
  for (const auto& light : rig.plant.lights()) {
    const auto next =
        std::find_if(moves.begin(), moves.end(), [&](const auto& move) { return move.first > light.began; });
    ASSERT_TRUE(next != moves.begin() && next != moves.end());
    EXPECT_GE(light.began - std::prev(next)->second, 3s) << light.layer;
    EXPECT_LT(light.began - std::prev(next)->second, 3s + 100ms) << light.layer << ": the mask comes meanwhile";
    EXPECT_GE(next->first - light.ended, 2s - 5ms) << light.layer;
    EXPECT_LT(next->first - light.ended, 2s + 100ms) << light.layer;
  }
}

TEST(Print, RendersTheNextMaskWhileALayerCures) {
  auto settings = rig_plant();
  settings.compute_per_mask = 800ms;
  Rig rig(settings);
  const auto& report = rig.run();
  EXPECT_EQ(report.state, kFinished);
  for (const auto& line : report.exposures) {
    EXPECT_EQ(line.next_made, line.layer + 1 < Rig::kLayers);
    if (line.next_made) {
      EXPECT_EQ(line.slack, line.asked - 800ms);
    }
  }
}

TEST(Print, LateMaskDelaysTheNextExposureAndShortensNone) {
  auto settings = rig_plant();
  settings.compute_per_mask = 4s;  // normal layers are lit for 2.5 s
  Rig rig(settings);
  const auto& report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(report.state, kFinished);
  EXPECT_GT(report.late_masks, 30U);
  EXPECT_EQ(rig.objections(), "");
  for (const auto& line : report.exposures) EXPECT_EQ(line.lit, exposure_of(rig.plan, line.layer));
}

TEST(Print, PausesAfterTheLayerRaisesThePartAndGoesOn) {
  Rig rig(with_fault("button.pause@layer=20"));
  const auto& report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  EXPECT_THAT(rig.user.states,
              ElementsAre(kChecks, kHoming, kPrinting, kPausing, kPaused, kPrinting, kFinishing, kFinished));
  EXPECT_EQ(rig.part(), whole_part());
  EXPECT_EQ(rig.objections(), "");
  EXPECT_EQ(report.pauses, 1U);
}

// Regression: the stage did not know its height yet, so raising it was PL-903, a mistake in the firmware.
TEST(Print, CancelledWhileItHomesIsCancelled) {
  Rig rig(with_fault("button.cancel@t=2s"));
  const auto& report = rig.run();
  EXPECT_EQ(report.state, kCancelled) << report.fault_message.c_str();
  EXPECT_THAT(rig.user.states, ElementsAre(kChecks, kHoming, kCancelling, kCancelled));
  EXPECT_TRUE(rig.plant.lights().empty());
}

TEST(Print, CancelledIsDarkAtOnceAndRaised) {
  Rig rig(with_fault("button.cancel@layer=20+1s"));
  const auto& report = rig.run();
  rig.plant.conclude(JobEnd::kAbandoned);
  EXPECT_EQ(report.state, kCancelled);
  EXPECT_EQ(report.next_layer, 20U);
  EXPECT_EQ(report.pauses, 0U) << "a cancel is no pause";
  EXPECT_EQ(rig.objections(), "");
  EXPECT_EQ(report.exposures.back().lit, 1s) << "the layer was not finished";
  EXPECT_EQ(rig.plant.stage().height(), 174_mm);
}

TEST(Print, OpenedCoverDarkensTheLampWithin10MsAndTheLayerGetsTheRestOfItsLight) {
  for (const char* when : {"0s", "0.3s", "1.2s", "2.4s"}) {
    Rig rig(with_fault(std::string("cover.opens@layer=20+") + when + ",for=30s"));
    const auto& report = rig.run();
    rig.plant.conclude(JobEnd::kFinished);
    EXPECT_EQ(report.state, kFinished) << when;
    EXPECT_THAT(rig.user.states,
                ElementsAre(kChecks, kHoming, kPrinting, kCoverOpen, kPaused, kPrinting, kFinishing, kFinished));
    EXPECT_EQ(rig.objections(), "") << when << ": the layer's dose is whole, too";
    EXPECT_EQ(rig.part(), whole_part());
  }
}

TEST(Print, WaitsAsLongAsTheCoverIsOpen) {
  Rig rig(with_fault("cover.opens@layer=20+1s,for=1000s"));
  const auto& report = rig.run();
  EXPECT_EQ(report.state, kFinished);
  const auto lights = rig.plant.lights();
  // The first light of layer 20 and the second: both at its height, a thousand seconds apart.
  const auto twice =
      std::find_if(lights.begin(), lights.end(), [](const LightRecord& light) { return light.layer == 20; });
  ASSERT_NE(twice, lights.end());
  EXPECT_GT((twice + 1)->began - twice->ended, 1000s);
}

TEST(Print, CoolsDownAndGoesOnByItself) {
  Rig rig(with_fault("temperature.lamp_hot@layer=10,for=600s"));
  rig.user.presses_start = false;
  const auto& report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(report.state, kFinished);
  EXPECT_THAT(rig.user.states,
              ElementsAre(kChecks, kHoming, kPrinting, kCoolingDown, kPrinting, kFinishing, kFinished));
  EXPECT_EQ(rig.objections(), "");
}

TEST(Print, AsksForResinWhenTheTankIsNearlyEmpty) {
  Rig rig;
  const double all_ml = 40 * 42 * 40 * resin_ml(1, kRigPitchMm, kRigPitchMm, 0.05);
  rig.give_tank(all_ml / 2.5);
  const auto& report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(report.state, kFinished);
  EXPECT_EQ(std::count(rig.user.states.begin(), rig.user.states.end(), kFeedMe), 2);
  EXPECT_EQ(rig.part(), whole_part());
  EXPECT_EQ(rig.objections(), "");
}

TEST(Print, ShutDownWithinALayerResumesWithTheRestOfItsLight) {
  Rig rig(with_fault("system.shutdown@layer=20+1s"));
  EXPECT_EQ(rig.run().state, kSuspended);
  const auto& report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(report.state, kFinished);
  EXPECT_EQ(report.first_layer, 20U);
  EXPECT_EQ(rig.part(), whole_part());
  EXPECT_EQ(rig.objections(), "") << "the light it had was in the journal";
}

TEST(Print, EndsWhenItsJournalCannotBeWritten) {
  Rig rig;
  rig.plant.timeline().at(TimePoint() + 200s, [&rig] { rig.storage.broken = true; });
  const auto& report = rig.run();
  EXPECT_EQ(report.state, kFault);
  EXPECT_EQ(report.fault, FaultCode::kCannotWrite);
  EXPECT_FALSE(rig.plant.light());
}

TEST(Print, ShowsItsStateOnThePanelsLights) {
  Rig rig(with_fault("lamp.dead@layer=5"));
  const auto& report = rig.run();
  EXPECT_EQ(report.fault, FaultCode::kLampDead);
  EXPECT_EQ(rig.machine().panel().light(PanelLight::kFault), LightState::kOn);
  EXPECT_EQ(rig.machine().panel().light(PanelLight::kPrinting), LightState::kOff);
  EXPECT_GE(rig.machine().panel().beeps(), 1U);
}

TEST(PrintChecks, FailForALampThatIsLitAlready) {
  auto settings = rig_plant();
  settings.faults.push_back(parse_fault("lamp.stuck_on@t=0s").value());
  Rig rig(settings);
  rig.plant.wait(1ms);
  rig.plant.lamp_line(true);
  rig.plant.lamp_line(false);
  ASSERT_TRUE(rig.plant.light());
  const auto& report = rig.run();
  EXPECT_EQ(report.fault, FaultCode::kLampStuckOn) << report.fault_message.c_str();
  ASSERT_FALSE(rig.user.failed_checks.empty());
  EXPECT_EQ(rig.user.failed_checks.front(), Check::kLampDark);
  EXPECT_FALSE(report.begun);
}

TEST(PrintChecks, FailForEachReason) {
  struct Row {
    Check check;
    FaultCode code;
    std::function<void(PlantSettings&)> spoil;
  };
  const auto fault = [](const char* text) {
    return [text](PlantSettings& plant) { plant.faults.push_back(parse_fault(text).value()); };
  };
  const Row rows[] = {
      {Check::kPanel, FaultCode::kPanelSize, [](PlantSettings& plant) { plant.panel.columns = 128; }},
      {Check::kPanel, FaultCode::kPanelFailed, fault("panel.dead@t=0s")},
      {Check::kCover, FaultCode::kCoverOpen, fault("cover.opens@t=0s")},
      {Check::kTemperatures, FaultCode::kSensorDead, fault("temperature.resin_sensor_wild@t=0s")},
      {Check::kTemperatures, FaultCode::kSensorDead, fault("temperature.lamp_sensor_dead@t=0s")},
      {Check::kStage, FaultCode::kEndStopNotFound, fault("stage.endstop_dead@t=0s")},
      {Check::kStage, FaultCode::kEndStopStuck, fault("stage.endstop_stuck@t=0s")},
  };
  for (const auto& row : rows) {
    auto settings = rig_plant();
    row.spoil(settings);
    Rig rig(settings);
    rig.plant.wait(1ms);  // lets faults that are due at 0 s start
    const auto& report = rig.run();
    EXPECT_EQ(report.state, kFault) << to_string(row.check);
    EXPECT_EQ(report.fault, row.code) << report.fault_message.c_str();
    EXPECT_THAT(rig.user.failed_checks, ElementsAre(row.check));
    EXPECT_TRUE(rig.plant.lights().empty()) << "nothing was lit";
  }
}

TEST(Print, ResumedInAnotherProcessGoesOnWithThePartOnThePlate) {
  Rig rig(with_fault("power.cut@layer=20"));
  EXPECT_EQ(rig.run().state, kSuspended);
  // The next process simulates a new printer, so the first layers have to be described to it.
  auto settings = rig_plant();
  settings.layers_on_plate = 20;
  settings.height_on_plate = height_of(rig.plan, 19);
  Rig resumed(settings);
  resumed.storage.medium() = rig.storage.medium();
  const auto& report = resumed.run();
  resumed.plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(report.state, kFinished);
  EXPECT_EQ(report.first_layer, 20U);
  EXPECT_EQ(resumed.objections(), "");
  EXPECT_EQ(resumed.plant.lights().front().layer, 20U);
}

TEST(PrintChecks, FailForAnExposureThatDoesNotCureALayer) {
  Rig rig;
  rig.profile.critical_energy = 8;  // a layer's 8.75 mJ/cm2 then cure only 0.01 mm deep
  EXPECT_EQ(rig.run().fault, FaultCode::kTooLittleLight);
}

}  // namespace
}  // namespace plumbline::firmware
