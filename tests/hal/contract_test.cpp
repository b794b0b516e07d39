/// What every back end of the HAL promises: run against each rig of rigs.cpp.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "hal/await.hpp"
#include "hal/ramp.hpp"
#include "tests/hal/rig.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

class Contract : public testing::TestWithParam<RigMaker> {
 protected:
  void SetUp() override {
    rig_ = GetParam().make();
    ASSERT_NE(rig_, nullptr);
  }

  void home() {
    const auto homed = rig_->machine().stage.home();
    ASSERT_TRUE(homed) << homed.error().message();
    forget_events();
  }
  void show_a_mask() {
    auto mask = rig_->machine().mask.lend();
    ASSERT_TRUE(mask);
    mask->image().clear();
    mask->image().set(3, 5);
    const auto shown = rig_->machine().mask.present(std::move(*mask));
    ASSERT_TRUE(shown) << shown.error().message();
  }
  void forget_events() {
    while (rig_->machine().events.next_event(TimePoint())->has_value()) {
    }
  }
  /// The kinds of all that happens in `time`.
  std::vector<EventKind> events_in(nanoseconds time) {
    std::vector<EventKind> kinds;
    const TimePoint end = rig_->machine().clock.now() + time;
    while (const auto event = rig_->machine().events.next_event(end).value()) kinds.push_back(event->kind);
    return kinds;
  }

  std::unique_ptr<Rig> rig_;
};

template <class Result>
testing::AssertionResult failed_with(const Result& result, ErrorCode code) {
  if (result) return testing::AssertionFailure() << "it succeeded";
  if (result.error().code() == code) return testing::AssertionSuccess();
  return testing::AssertionFailure() << to_string(result.error().code()) << ": " << result.error().message();
}

// --- Clock and events

TEST_P(Contract, TimePassesAndNeverGoesBack) {
  Clock& clock = rig_->machine().clock;
  const TimePoint start = clock.now();
  ASSERT_TRUE(clock.sleep_until(start + 20ms));
  EXPECT_GE(clock.now(), start + 20ms);
  EXPECT_LT(clock.now(), start + 120ms);
  ASSERT_TRUE(clock.sleep_until(start));
  EXPECT_LT(clock.now(), start + 120ms);
}

TEST_P(Contract, WaitingForAnEventEndsAtItsDeadline) {
  const Machine machine = rig_->machine();
  const TimePoint start = machine.clock.now();
  const auto event = machine.events.next_event(start + 50ms);
  ASSERT_TRUE(event);
  EXPECT_FALSE(event->has_value());
  EXPECT_GE(machine.clock.now(), start + 50ms);
  EXPECT_LT(machine.clock.now(), start + 150ms);
}

TEST_P(Contract, EventsComeInOrderWithTheTimeTheyHappenedAt) {
  const Machine machine = rig_->machine();
  const TimePoint start = machine.clock.now();
  rig_->press(EventKind::kPausePressed, 30ms);
  rig_->press(EventKind::kCancelPressed, 60ms);
  const auto first = machine.events.next_event(start + 1s).value();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->kind, EventKind::kPausePressed);
  EXPECT_LT(machine.clock.now() - first->at, 10ms);
  ASSERT_TRUE(machine.clock.sleep_until(start + 500ms));
  const auto second = machine.events.next_event(start + 1s).value();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->kind, EventKind::kCancelPressed);
  EXPECT_NEAR(std::chrono::duration<double>(second->at - start).count(), 0.06, 0.01);
  EXPECT_FALSE(machine.events.next_event(start).value());
}

// --- Mask

TEST_P(Contract, AMaskIsLentOnceAndComesBackWhenItIsLetGo) {
  MaskDisplay& display = rig_->machine().mask;
  {
    const auto mask = display.lend();
    ASSERT_TRUE(mask);
    EXPECT_EQ(mask->image().columns(), display.columns());
    EXPECT_EQ(mask->image().rows(), display.rows());
    EXPECT_TRUE(failed_with(display.lend(), ErrorCode::kBusy));
  }
  EXPECT_TRUE(display.lend());
}

TEST_P(Contract, AMaskThatIsOnThePanelCantBeWritten) {
  MaskDisplay& display = rig_->machine().mask;
  auto first = display.lend();
  ASSERT_TRUE(first);
  const auto* const words = first->image().words().data();
  ASSERT_TRUE(display.present(std::move(*first)));
  EXPECT_EQ(first->image().columns(), 0U);
  const auto second = display.lend();
  ASSERT_TRUE(second);
  EXPECT_NE(second->image().words().data(), words);
}

TEST_P(Contract, AMaskIsPresentedUntilThePanelIsBlank) {
  MaskDisplay& display = rig_->machine().mask;
  EXPECT_FALSE(display.presented());
  show_a_mask();
  EXPECT_TRUE(display.presented());
  ASSERT_TRUE(display.blank());
  EXPECT_FALSE(display.presented());
}

TEST_P(Contract, NeitherMaskNorBlackIsShownUnderLight) {
  const Machine machine = rig_->machine();
  show_a_mask();
  auto next = machine.mask.lend();
  ASSERT_TRUE(next);
  auto exposure = machine.lamp.begin_exposure(1s);
  ASSERT_TRUE(exposure);
  EXPECT_TRUE(failed_with(machine.mask.present(std::move(*next)), ErrorCode::kLampLit));
  EXPECT_GT(next->image().columns(), 0U) << "a mask that was refused is still the caller's";
  EXPECT_TRUE(failed_with(machine.mask.blank(), ErrorCode::kLampLit));
  EXPECT_TRUE(machine.mask.presented());
  ASSERT_TRUE(exposure->finish());
  EXPECT_TRUE(machine.mask.present(std::move(*next)));
}

// --- Lamp

TEST_P(Contract, ALampIsLitForTheTimeAsked) {
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
    // The 1 ms above, and 1 %.
    const Irradiance irradiance = machine.lamp.limits().irradiance;
    const double dose = dose_of(irradiance, cure).value();
    EXPECT_NEAR(report->dose.value(), dose, dose_of(irradiance, 1ms).value() + 0.01 * dose);
  }
}

TEST_P(Contract, ALampGoesDarkByItselfWhileTheFirmwareComputes) {
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

TEST_P(Contract, TheEndOfAnExposureIsAnEvent) {
  const Machine machine = rig_->machine();
  show_a_mask();
  auto exposure = machine.lamp.begin_exposure(200ms);
  ASSERT_TRUE(exposure);
  EXPECT_THAT(events_in(500ms), testing::ElementsAre(EventKind::kExposureEnded));
}

TEST_P(Contract, AnExposureThatIsFinishedEarlySaysHowMuchIsMissing) {
  const Machine machine = rig_->machine();
  show_a_mask();
  rig_->press(EventKind::kPausePressed, 300ms);
  auto exposure = machine.lamp.begin_exposure(2s);
  ASSERT_TRUE(exposure);
  const auto over = await(*exposure, machine.events, machine.clock, [](const Event&) { return Waiting::kLeave; });
  ASSERT_TRUE(over);
  EXPECT_FALSE(*over);
  const auto report = exposure->finish();
  ASSERT_TRUE(report);
  EXPECT_EQ(report->end, ExposureEnd::kStopped);
  EXPECT_NEAR(std::chrono::duration<double>(report->lit).count(), 0.3, 0.01);
  EXPECT_FALSE(rig_->light());
}

TEST_P(Contract, ALampIsDarkWhenItsExposureGoesOutOfScope) {
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

TEST_P(Contract, ALampIsDarkTenMillisecondsAfterTheCoverOpenedWhateverTheFirmwareDoes) {
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

TEST_P(Contract, ALampRefusesWhatMustNotBeLit) {
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

// --- Stage

TEST_P(Contract, AStageKnowsItsHeightOnceItIsHomed) {
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

TEST_P(Contract, AMoveArrivesInTheTimeOfItsRamp) {
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
    EXPECT_NEAR(moved->at.above_film().micrometres(), height.micrometres(), 1);
    EXPECT_NEAR(rig_->plate_height().micrometres(), height.micrometres(), 5);
    EXPECT_EQ(moved->steps_lost, Distance());
  }
}

TEST_P(Contract, AStageDoesNotTakeAStepBeyondItsTravel) {
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

TEST_P(Contract, AStageDoesNotMoveUnderLight) {
  const Machine machine = rig_->machine();
  home();
  show_a_mask();
  const auto exposure = machine.lamp.begin_exposure(1s);
  ASSERT_TRUE(exposure);
  EXPECT_TRUE(failed_with(machine.stage.begin_move(machine.stage.limits().lowest, Speed(1)), ErrorCode::kLampLit));
  EXPECT_TRUE(failed_with(machine.stage.begin_homing(), ErrorCode::kLampLit));
  EXPECT_FALSE(machine.stage.moving());
}

TEST_P(Contract, AMotionIsInterruptedByWhatHappensMeanwhileAndKnowsItsHeightAfterwards) {
  const Machine machine = rig_->machine();
  home();
  rig_->press(EventKind::kCancelPressed, 1s);
  auto motion = machine.stage.begin_move(ZPosition(100_mm), Speed(5));
  ASSERT_TRUE(motion);
  const TimePoint planned = motion->ends_by();
  EXPECT_TRUE(failed_with(machine.stage.begin_move(ZPosition(50_mm), Speed(5)), ErrorCode::kBusy));
  const auto over = await(*motion, machine.events, machine.clock, [](const Event&) { return Waiting::kLeave; });
  ASSERT_TRUE(over);
  EXPECT_FALSE(*over);
  ASSERT_TRUE(motion->stop());
  EXPECT_LT(motion->ends_by(), planned);
  EXPECT_LE(motion->ends_by() - machine.clock.now(), 150ms);  // v / a = 0.1 s
  const auto report = motion->finish();
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->arrived);
  // 1 s at 5 mm/s, less half of speeding up, and half of slowing down: 5 mm
  EXPECT_NEAR((machine.stage.limits().highest - report->at).millimetres(), 5.0, 0.1);
  EXPECT_NEAR(rig_->plate_height().micrometres(), report->at.above_film().micrometres(), 5);
  EXPECT_EQ(machine.stage.position().value(), report->at);
}

TEST_P(Contract, AStageStandsWhenItsMotionGoesOutOfScope) {
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

TEST_P(Contract, HomingCanBeStoppedAndThenTheHeightIsNotKnown) {
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

TEST_P(Contract, TheEndOfAMotionIsAnEvent) {
  home();
  auto motion = rig_->machine().stage.begin_move(ZPosition(165_mm), Speed(5));
  ASSERT_TRUE(motion);
  EXPECT_THAT(events_in(3s), testing::ElementsAre(EventKind::kMotionEnded));
  EXPECT_TRUE(motion->over());
}

// --- Stick

class Stick : public Contract {
 protected:
  void SetUp() override {
    Contract::SetUp();
    folder_ = std::filesystem::path(testing::TempDir()) / ("stick-" + std::to_string(::getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_ / "scans");
    write("bust.ply", std::string(300'000, 'p'));
    write("job.toml", "[job]\n");
    write(".hidden", "x");
    write("scans/arm.xyz", "1 2 3\n");
    std::filesystem::create_symlink("/etc/passwd", folder_ / "link.ply");
    std::filesystem::create_directory_symlink("/etc", folder_ / "etc");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const char* name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  void plug() {
    rig_->plug_stick(folder_.string(), 0ns);
    ASSERT_THAT(events_in(2s), testing::ElementsAre(EventKind::kStickArrived));
  }
  std::filesystem::path folder_;
};

TEST_P(Stick, ArrivesIsMountedReadAndLeaves) {
  StickPort& port = rig_->machine().stick;
  EXPECT_FALSE(port.present());
  EXPECT_TRUE(failed_with(port.identity(), ErrorCode::kNoStick));
  EXPECT_TRUE(failed_with(port.mount(), ErrorCode::kNoStick));
  plug();
  EXPECT_TRUE(port.present());
  EXPECT_NE(port.identity().value().vendor_id, 0);
  {
    const auto mount = port.mount();
    ASSERT_TRUE(mount) << mount.error().message();
    EXPECT_FALSE(mount->path().empty());
    EXPECT_TRUE(failed_with(port.mount(), ErrorCode::kBusy));
    auto file = mount->open("job.toml");
    ASSERT_TRUE(file) << file.error().message();
    EXPECT_EQ(file->name(), "job.toml");
    EXPECT_EQ(file->size(), 6U);
    std::array<std::byte, 100> buffer{};
    EXPECT_EQ(file->read(buffer).value(), 6U);
    EXPECT_EQ(file->read(buffer).value(), 0U);
    EXPECT_TRUE(mount->open("scans/arm.xyz"));
    EXPECT_TRUE(mount->open("./scans//arm.xyz"));
  }
  EXPECT_TRUE(port.mount());
  rig_->pull_stick(0ns);
  EXPECT_THAT(events_in(2s), testing::ElementsAre(EventKind::kStickDeparted));
  EXPECT_FALSE(port.present());
}

TEST_P(Stick, ListsItsPlainFiles) {
  plug();
  struct Names final : StickMount::FileVisitor {
    void file(std::string_view name, std::uint64_t bytes) override { sizes[std::string(name)] = bytes; }
    std::map<std::string, std::uint64_t> sizes;
  } names;
  const auto mount = rig_->machine().stick.mount();
  ASSERT_TRUE(mount);
  ASSERT_TRUE(mount->for_each_file(names));
  ASSERT_TRUE(mount->for_each_file(names)) << "a second time too";
  EXPECT_THAT(names.sizes, testing::ElementsAre(testing::Pair("bust.ply", 300'000), testing::Pair("job.toml", 6)));
}

TEST_P(Stick, KeepsItsNamesBelowItsMount) {
  plug();
  const auto mount = rig_->machine().stick.mount();
  ASSERT_TRUE(mount);
  for (const char* name : {"", "/etc/passwd", "../x", "scans/../../x", "..", "link.ply", "etc/passwd", "scans",
                           "none.ply", "scans/arm.xyz/", "."}) {
    EXPECT_TRUE(failed_with(mount->open(name), ErrorCode::kCannotOpen)) << name;
  }
  EXPECT_TRUE(failed_with(mount->open(std::string(5000, 'a')), ErrorCode::kCannotOpen));
  EXPECT_TRUE(failed_with(mount->open(std::string_view("job.toml\0x", 10)), ErrorCode::kCannotOpen));
}

TEST_P(Stick, PulledInMidReadIsAnErrorAndTheNextOneIsRead) {
  plug();
  {
    const auto mount = rig_->machine().stick.mount();
    ASSERT_TRUE(mount);
    auto file = mount->open("bust.ply");
    ASSERT_TRUE(file);
    std::array<std::byte, 1000> buffer{};
    ASSERT_TRUE(file->read(buffer));
    rig_->pull_stick(0ns);
    EXPECT_THAT(events_in(1s), testing::ElementsAre(EventKind::kStickDeparted));
    EXPECT_TRUE(failed_with(file->read(buffer), ErrorCode::kStickGone));
    rig_->plug_stick(folder_.string(), 0ns);
    EXPECT_THAT(events_in(1s), testing::ElementsAre(EventKind::kStickArrived));
    EXPECT_TRUE(failed_with(file->read(buffer), ErrorCode::kStickGone))
        << "that it is back helps no file that was open";
  }
  const auto mount = rig_->machine().stick.mount();
  ASSERT_TRUE(mount);
  EXPECT_TRUE(mount->open("bust.ply"));
}

// --- Panel and temperatures

TEST_P(Contract, ThePanelSaysWhetherTheCoverIsOpen) {
  const Machine machine = rig_->machine();
  EXPECT_FALSE(machine.panel.cover_open());
  rig_->open_cover(0ns);
  EXPECT_THAT(events_in(100ms), testing::ElementsAre(EventKind::kCoverOpened));
  EXPECT_TRUE(machine.panel.cover_open());
  for (const auto light : {PanelLight::kReady, PanelLight::kPrinting, PanelLight::kAttention, PanelLight::kFault}) {
    EXPECT_TRUE(machine.panel.set_light(light, LightState::kBlinking));
  }
  EXPECT_TRUE(machine.panel.beep(10ms));
}

TEST_P(Contract, TemperaturesAreThoseOfARoom) {
  const Machine machine = rig_->machine();
  for (const auto site : {TemperatureSite::kLamp, TemperatureSite::kResin, TemperatureSite::kBoard}) {
    const auto read = machine.thermals.temperature(site);
    ASSERT_TRUE(read);
    EXPECT_GT(read->value(), 0);
    EXPECT_LT(read->value(), 90);
  }
  for (const auto fan : {Fan::kLamp, Fan::kChamber}) {
    EXPECT_TRUE(machine.thermals.set_fan(fan, 1));
    EXPECT_NE(machine.thermals.fan_health(fan), FanHealth::kStalled);
  }
}

const auto kName = [](const testing::TestParamInfo<RigMaker>& info) { return std::string(info.param.name); };
INSTANTIATE_TEST_SUITE_P(Hal, Contract, testing::ValuesIn(rig_makers()), kName);
INSTANTIATE_TEST_SUITE_P(Hal, Stick, testing::ValuesIn(rig_makers()), kName);

}  // namespace
}  // namespace plumbline
