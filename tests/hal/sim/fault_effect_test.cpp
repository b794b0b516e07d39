/// Every fault has the effect given in the table. Each starts at layer 2 of a 5-layer print.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <ostream>

#include "hal/sim/sim_machine.hpp"
#include "tests/hal/sim/sim_fixture.hpp"
#include "tests/hal/small_print.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

/// What a fault at layer 2 does to a firmware that checks only for errors.
struct Effect {
  FaultKind kind;
  std::optional<ErrorCode> error = std::nullopt;          ///< ends the print
  std::vector<ObjectionKind> objections = {};             ///< in the whole print
  const char* option = "";                                ///< for the fault
  std::function<void(const Machine&, Plant&)> then = {};  ///< checks after the print
};

std::ostream& operator<<(std::ostream& out, const Effect& effect) { return out << row_of(effect.kind).name; }

std::vector<EventKind> all_events(const Machine& machine) {
  std::vector<EventKind> kinds;
  while (const auto event = machine.events.next_event(TimePoint()).value()) kinds.push_back(event->kind);
  return kinds;
}

ErrorCode code_of_homing(const Machine& machine) { return machine.stage.home().error().code(); }

void is_too_hot_or_cold(const Machine& machine, TemperatureSite site, double degrees) {
  EXPECT_NEAR(machine.thermals.temperature(site).value().value(), degrees, 1e-9);
}

void sensor_is_dead(const Machine& machine, TemperatureSite site) {
  const auto read = machine.thermals.temperature(site);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code(), ErrorCode::kSensorDead);
}

std::vector<Effect> effects() {
  using F = FaultKind;
  using E = ErrorCode;
  using O = ObjectionKind;
  const auto stays_dark = [](const Machine& machine, Plant& plant) {
    EXPECT_FALSE(plant.light());
    EXPECT_LE(plant.lights().back().ended - plant.lights().back().began, 2500ms + 20ms);
    auto mask = machine.mask.lend();
    ASSERT_TRUE(mask);
    ASSERT_TRUE(machine.mask.present(std::move(*mask)));
    EXPECT_EQ(machine.lamp.begin_exposure(1s).error().code(), E::kLampFailed);
  };
  const auto is_still_lit = [](const Machine& machine, Plant& plant) {
    EXPECT_TRUE(plant.light());
    EXPECT_TRUE(machine.lamp.lit());
  };
  const auto late_masks = [](const Machine& machine, Plant&) {
    const TimePoint before = machine.clock.now();
    ASSERT_TRUE(machine.mask.lend());
    EXPECT_EQ(machine.clock.now() - before, 5s);
  };
  const auto not_homed = [](const Machine& machine, Plant&) { EXPECT_FALSE(machine.stage.homed()); };
  const auto lost_steps = [](const Machine& machine, Plant& plant) {
    EXPECT_NEAR((machine.stage.position().value().above_film() - plant.stage().height()).millimetres(), 0.2, 1e-6);
    // The plate is 0.2 mm too low, so it meets the end stop 0.2 mm later than expected.
    EXPECT_NEAR(machine.stage.home().value().steps_lost.millimetres(), 0.2, 0.00126);
  };
  const auto stick_is_gone = [](const Machine& machine, Plant&) { EXPECT_FALSE(machine.stick.has_stick()); };
  const auto first_read = [](const Machine& machine, ErrorCode code) {
    const auto mount = machine.stick.mount();
    ASSERT_TRUE(mount);
    auto file = mount->open("scan.xyz");
    ASSERT_TRUE(file);
    std::array<std::byte, 50'000> buffer{};
    const auto read = file->read(buffer);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code(), code);
  };
  const auto fan_stalls = [](Fan fan) {
    return [fan](const Machine& machine, Plant&) {
      EXPECT_EQ(machine.thermals.fan_health(fan), FanHealth::kOk) << "it should not turn";
      ASSERT_TRUE(machine.thermals.set_fan(fan, 0.5));
      EXPECT_EQ(machine.thermals.fan_health(fan), FanHealth::kStalled);
    };
  };
  const auto heat = [](TemperatureSite site, double degrees) {
    return [=](const Machine& machine, Plant&) { is_too_hot_or_cold(machine, site, degrees); };
  };
  const auto dead = [](TemperatureSite site) {
    return [=](const Machine& machine, Plant&) { sensor_is_dead(machine, site); };
  };
  // The print reads the events during layer 2's exposure, so press again afterwards.
  const auto pressed = [](EventKind button) {
    return [button](const Machine& machine, Plant&) { EXPECT_THAT(all_events(machine), testing::Contains(button)); };
  };
  return {
      {.kind = F::kLampStuckOn, .error = E::kLampStuckOn, .then = stays_dark},
      {.kind = F::kLampRunaway, .error = E::kLampStuckOn, .then = is_still_lit},
      {.kind = F::kLampDead, .error = E::kLampDead},
      {.kind = F::kLampWeak, .objections = {O::kDoseOff, O::kDoseOff, O::kDoseOff}},
      {.kind = F::kLampDies,
       .objections = {O::kDoseOff, O::kNotBonded, O::kDoseOff, O::kNotBonded, O::kDoseOff, O::kNotBonded}},
      {.kind = F::kLampFlickers, .objections = {O::kDoseOff, O::kDoseOff, O::kDoseOff}},
      {.kind = F::kLampSlowRise, .objections = {O::kDoseOff, O::kDoseOff, O::kDoseOff}},
      {.kind = F::kLampUnarmed, .error = E::kLampFailed},
      {.kind = F::kPanelFlipTimeout, .error = E::kFlipTimeout},
      {.kind = F::kPanelTorn, .objections = {O::kMaskTornUnderLight, O::kMaskTornUnderLight, O::kMaskTornUnderLight}},
      // The old mask is the black one after the last layer, so nothing cures.
      {.kind = F::kPanelStale, .objections = {O::kMaskTornUnderLight, O::kMaskTornUnderLight, O::kMaskTornUnderLight}},
      {.kind = F::kPanelDead, .error = E::kPanelFailed},
      {.kind = F::kPanelSlow},
      {.kind = F::kPanelSlow, .error = E::kFlipTimeout, .option = ",by=1"},
      {.kind = F::kStageEndStopStuck,
       .then =
           [](const Machine& machine, Plant& plant) {
             const Distance before = plant.stage().height();
             EXPECT_EQ(code_of_homing(machine), E::kEndStopStuck);
             EXPECT_EQ(plant.stage().height(), before) << "homing does not start where the end stop can't be";
           }},
      {.kind = F::kStageEndStopDead,
       .then =
           [](const Machine& machine, Plant&) {
             EXPECT_EQ(code_of_homing(machine), E::kEndStopNotFound);
             EXPECT_FALSE(machine.stage.homed());
           }},
      // At 0.15 mm, layer 2 is 50 um below the film; later layers are above it again.
      {.kind = F::kStageSkips, .objections = {O::kTravelPastEnd}, .then = lost_steps},
      {.kind = F::kStageStalls, .error = E::kStageStalled, .then = not_homed},
      {.kind = F::kResinSticks, .objections = {O::kLiftSkipped, O::kLiftSkipped, O::kLiftSkipped}},
      {.kind = F::kResinWeak, .objections = {O::kNotBonded, O::kNotBonded, O::kNotBonded}},
      {.kind = F::kComputeSlow, .then = late_masks},
      {.kind = F::kCoverOpens, .error = E::kCoverOpen},
      {.kind = F::kCoverOpens,
       .error = E::kCoverOpen,
       .option = ",for=1s",
       .then =
           [](const Machine& machine, Plant& plant) {
             ASSERT_TRUE(plant.wait(1s));
             EXPECT_FALSE(machine.panel.cover_open());
           }},
      {.kind = F::kCoverSwitchDead,
       .error = E::kCoverOpen,
       .then =
           [](const Machine& machine, Plant& plant) {
             plant.close_cover();
             EXPECT_TRUE(machine.panel.cover_open());
           }},
      {.kind = F::kStickPulled, .then = stick_is_gone},
      {.kind = F::kStickPulled,
       .option = ",for=1s",
       .then = [](const Machine& machine, Plant&) { EXPECT_TRUE(machine.stick.has_stick()); }},
      {.kind = F::kStickSlow,
       .then =
           [](const Machine& machine, Plant&) {
             const TimePoint before = machine.clock.now();
             const auto mount = machine.stick.mount();
             auto file = mount->open("scan.xyz");
             std::array<std::byte, 50'000> buffer{};
             ASSERT_EQ(file->read(buffer).value(), 40'000U);
             // 40000 bytes at a hundredth of 20 MB/s
             EXPECT_EQ(machine.clock.now() - before, 200ms);
           }},
      {.kind = F::kStickBadSector,
       .then = [=](const Machine& machine, Plant&) { first_read(machine, E::kCannotRead); }},
      {.kind = F::kStickMountFails,
       .then = [](const Machine& machine,
                  Plant&) { EXPECT_EQ(machine.stick.mount().error().code(), E::kMountFailed); }},
      {.kind = F::kTemperatureLampHot, .then = heat(TemperatureSite::kLamp, 95)},
      {.kind = F::kTemperatureLampSensorDead, .then = dead(TemperatureSite::kLamp)},
      {.kind = F::kTemperatureResinCold, .then = heat(TemperatureSite::kResin, 8)},
      {.kind = F::kTemperatureResinHot, .then = heat(TemperatureSite::kResin, 60)},
      {.kind = F::kTemperatureResinSensorDead, .then = dead(TemperatureSite::kResin)},
      {.kind = F::kTemperatureResinSensorWild, .then = dead(TemperatureSite::kResin)},
      {.kind = F::kTemperatureBoardHot, .then = heat(TemperatureSite::kBoard, 105)},
      {.kind = F::kFanLampStalls, .then = fan_stalls(Fan::kLamp)},
      {.kind = F::kFanChamberStalls, .then = fan_stalls(Fan::kChamber)},
      {.kind = F::kButtonStart, .option = "+60s", .then = pressed(EventKind::kStartPressed)},
      {.kind = F::kButtonPause, .option = "+60s", .then = pressed(EventKind::kPausePressed)},
      {.kind = F::kButtonCancel, .option = "+60s", .then = pressed(EventKind::kCancelPressed)},
      {.kind = F::kSystemShutdown, .option = "+60s", .then = pressed(EventKind::kShutdownRequested)},
      {.kind = F::kPowerCut, .error = E::kPowerLost},
  };
}

class FaultEffect : public testing::TestWithParam<Effect> {};

TEST_P(FaultEffect, MatchesTheTable) {
  const Effect& effect = GetParam();
  const auto folder = std::filesystem::path(testing::TempDir()) / ("fault-stick-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "scan.xyz") << std::string(40'000, '1');

  PlantSettings settings = small_printer({std::string(row_of(effect.kind).name) + "@layer=2" + effect.option});
  settings.stick = folder.string();
  Plant plant(settings);
  SimMachine machine(plant);
  const auto printed = print_layers(machine.machine(), {.layers = 5, .draw = draw_random});
  plant.conclude(printed ? JobEnd::kFinished : JobEnd::kAbandoned);
  if (effect.error) {
    ASSERT_FALSE(printed);
    EXPECT_EQ(printed.error().code(), *effect.error) << printed.error().message();
    EXPECT_LE(plant.part().layers().size(), 3U) << "layers 0 and 1 are complete, 2 may have begun";
    EXPECT_GE(plant.part().layers().size(), 2U);
  } else {
    ASSERT_TRUE(printed) << printed.error().message();
  }
  if (row_of(effect.kind).name.starts_with("button") || effect.kind == FaultKind::kSystemShutdown) {
    ASSERT_TRUE(plant.wait(60s));
  }
  EXPECT_EQ(kinds_of(plant.objections()), effect.objections) << testing::PrintToString(texts_of(plant.objections()));
  for (const Objection& objection : plant.objections()) EXPECT_GE(objection.layer, 2U);
  if (effect.then) effect.then(machine.machine(), plant);
  std::filesystem::remove_all(folder);
}

const auto kName = [](const auto& info) {
  std::string name(row_of(info.param.kind).name);
  for (char& letter : name) {
    if (letter == '.') letter = '_';
  }
  return name + "_" + std::to_string(info.index);
};
INSTANTIATE_TEST_SUITE_P(Sim, FaultEffect, testing::ValuesIn(effects()), kName);

TEST(FaultEffects, CoverTheWholeTable) {
  std::vector<bool> seen(kFaultKindCount, false);
  for (const Effect& effect : effects()) seen[static_cast<std::size_t>(effect.kind)] = true;
  for (const FaultRow& row : fault_table()) EXPECT_TRUE(seen[static_cast<std::size_t>(row.kind)]) << row.name;
}

}  // namespace
}  // namespace plumbline
