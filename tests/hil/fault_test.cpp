/// Every fault of the plant at the start, in the middle and at the end of a print; those of the stick while a scan is read.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hil/rig.hpp"
#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
namespace fault_test {

using enum PrintState;

/// How a print ends: its state and fault code.
struct End {
  PrintState state;
  FaultCode code = FaultCode::kNone;
  bool operator==(const End&) const = default;
};

constexpr End kAsIfNothing{kFinished};
constexpr End faulted(FaultCode code) { return {kFault, code}; }

/// Whether the plant may object: only to faults that no firmware could notice or undo.
enum class May : std::uint8_t { kNothing, kObjectToItself };

struct Row {
  const char* fault;
  const char* more;  ///< appended to the fault's text
  End start, middle, end;
  May may = May::kNothing;
};

// A stage that stalls while homing has met something before its end stop. A fault during the last exposure comes too late to be
// noticed.
const Row kRows[] = {
    {"lamp.stuck_on", "", faulted(FaultCode::kLampStuckOn), faulted(FaultCode::kLampStuckOn),
     faulted(FaultCode::kLampStuckOn), May::kObjectToItself},
    {"lamp.runaway", "", faulted(FaultCode::kLampStuckOn), faulted(FaultCode::kLampStuckOn),
     faulted(FaultCode::kLampStuckOn), May::kObjectToItself},
    {"lamp.dead", "", faulted(FaultCode::kLampDead), faulted(FaultCode::kLampDead), faulted(FaultCode::kLampDead)},
    {"lamp.weak", "", faulted(FaultCode::kDoseOff), faulted(FaultCode::kDoseOff), faulted(FaultCode::kDoseOff)},
    {"lamp.dies", "", faulted(FaultCode::kDoseOff), faulted(FaultCode::kDoseOff), faulted(FaultCode::kDoseOff)},
    {"lamp.flickers", "", faulted(FaultCode::kDoseOff), faulted(FaultCode::kDoseOff), faulted(FaultCode::kDoseOff)},
    {"lamp.slow_rise", ",by=1", faulted(FaultCode::kDoseOff), faulted(FaultCode::kDoseOff),
     faulted(FaultCode::kDoseOff)},
    {"lamp.unarmed", "", faulted(FaultCode::kLampKeeper), faulted(FaultCode::kLampKeeper),
     faulted(FaultCode::kLampKeeper)},
    {"panel.flip_timeout", "", faulted(FaultCode::kFlipTimeout), faulted(FaultCode::kFlipTimeout),
     faulted(FaultCode::kFlipTimeout)},
    {"panel.torn", "", kAsIfNothing, kAsIfNothing, kAsIfNothing, May::kObjectToItself},
    {"panel.stale", "", kAsIfNothing, kAsIfNothing, kAsIfNothing, May::kObjectToItself},
    {"panel.dead", "", faulted(FaultCode::kPanelFailed), faulted(FaultCode::kPanelFailed),
     faulted(FaultCode::kPanelFailed)},
    {"panel.slow", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"stage.endstop_stuck", "", faulted(FaultCode::kEndStopStuck), faulted(FaultCode::kEndStopStuck),
     faulted(FaultCode::kEndStopStuck)},
    {"stage.endstop_dead", "", faulted(FaultCode::kEndStopNotFound), faulted(FaultCode::kEndStopNotFound),
     faulted(FaultCode::kEndStopNotFound), May::kObjectToItself},
    {"stage.skips", "", kAsIfNothing, kAsIfNothing, kAsIfNothing, May::kObjectToItself},
    {"stage.stalls", "", faulted(FaultCode::kEndStopNotFound), faulted(FaultCode::kStageStalled),
     faulted(FaultCode::kStageStalled)},
    {"resin.sticks", "", kAsIfNothing, kAsIfNothing, kAsIfNothing, May::kObjectToItself},
    {"resin.weak", "", kAsIfNothing, kAsIfNothing, kAsIfNothing, May::kObjectToItself},
    {"compute.slow", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"cover.opens", ",for=5s", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"cover.switch_dead", "", {kCancelled}, {kCancelled}, {kCancelled}},
    {"temperature.lamp_hot", ",for=900s", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"temperature.lamp_sensor_dead", "", faulted(FaultCode::kSensorDead), faulted(FaultCode::kSensorDead),
     kAsIfNothing},
    {"temperature.resin_cold", ",for=900s", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"temperature.resin_hot", ",for=900s", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"temperature.resin_sensor_dead", "", faulted(FaultCode::kSensorDead), faulted(FaultCode::kSensorDead),
     kAsIfNothing},
    {"temperature.resin_sensor_wild", "", faulted(FaultCode::kSensorDead), faulted(FaultCode::kSensorDead),
     kAsIfNothing},
    {"temperature.board_hot", ",for=900s", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"fan.lamp_stalls", ",for=900s", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"fan.chamber_stalls", ",for=900s", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"button.start", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"button.pause", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"button.cancel", "", {kCancelled}, {kCancelled}, {kCancelled}},
    {"system.shutdown", "", {kSuspended}, {kSuspended}, {kSuspended}},
    {"power.cut",
     "",
     {kSuspended, FaultCode::kPowerLost},
     {kSuspended, FaultCode::kPowerLost},
     {kSuspended, FaultCode::kPowerLost}},
};

void PrintTo(const Row& row, std::ostream* out) { *out << row.fault; }

class EveryFault : public ::testing::TestWithParam<Row> {
 protected:
  void meet(std::uint32_t layer, const End& expected) {
    const Row& row = GetParam();
    const std::string text = std::string(row.fault) + "@layer=" + std::to_string(layer) + row.more;
    SCOPED_TRACE(text);
    auto settings = rig_plant();
    settings.faults.push_back(parse_fault(text).value());
    Rig rig(settings);
    const PrintReport& report = rig.run();
    rig.plant.conclude(report.state == kFinished ? JobEnd::kFinished : JobEnd::kAbandoned);

    EXPECT_EQ(to_string(report.state), to_string(expected.state)) << report.fault_message.c_str();
    EXPECT_EQ(static_cast<int>(report.fault), static_cast<int>(expected.code)) << report.fault_message.c_str();
    if (!rig.plant.powered()) rig.plant.restore_power();  // so that the lamp can go dark
    const bool can_be_dark = std::string_view(row.fault) != "lamp.runaway";
    EXPECT_EQ(rig.plant.light(), !can_be_dark);
    EXPECT_EQ(rig.objections_of(ObjectionKind::kLightWithCoverOpen), 0U);
    EXPECT_EQ(rig.objections_of(ObjectionKind::kMotionUnderLight), 0U) << rig.objections();
    EXPECT_EQ(rig.objections_of(ObjectionKind::kMaskChangedUnderLight), 0U) << rig.objections();
    if (row.may == May::kNothing) check_objections(rig, report);
    check_journal(rig, report);
  }

  /// A print that did not finish may have given its last layer too little light; nothing else may be wrong.
  static void check_objections(const Rig& rig, const PrintReport& report) {
    for (const auto& objection : rig.plant.objections()) {
      const bool unfinished =
          report.state != kFinished && objection.layer == report.next_layer &&
          (objection.kind == ObjectionKind::kDoseOff || objection.kind == ObjectionKind::kNotBonded);
      EXPECT_TRUE(unfinished) << to_string(objection);
    }
  }

  /// The journal must have every layer that was cured.
  static void check_journal(Rig& rig, const PrintReport& report) {
    const auto journal = Journal::open(rig.storage);
    ASSERT_TRUE(journal) << journal.error().message();
    EXPECT_EQ(journal->last().next_layer, report.next_layer);
  }
};

TEST_P(EveryFault, AtTheStart) { meet(0, GetParam().start); }
TEST_P(EveryFault, InTheMiddle) { meet(Rig::kLayers / 2, GetParam().middle); }
TEST_P(EveryFault, AtTheEnd) { meet(Rig::kLayers - 1, GetParam().end); }

INSTANTIATE_TEST_SUITE_P(Hil, EveryFault, ::testing::ValuesIn(kRows), [](const auto& row) {
  std::string name = row.param.fault;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

/// A fault of the stick, and what the daemon does.
struct StickRow {
  const char* fault;
  FaultCode code;      ///< while the scan is read
  double seconds = 0;  ///< that the fault adds to reading
};

const StickRow kStickRows[] = {
    {"stick.pulled", FaultCode::kStickGone},
    {"stick.slow", FaultCode::kNone, 100},
    {"stick.bad_sector", FaultCode::kScanUnreadable},
    {"stick.mount_fails", FaultCode::kStickUnreadable},
};

void PrintTo(const StickRow& row, std::ostream* out) { *out << row.fault; }

class EveryStickFault : public ::testing::TestWithParam<StickRow> {
 protected:
  /// Prints a scan from a stick that has the fault.
  /// @returns plant time of the print's first check; nothing if the scan was not read
  static std::optional<double> time_to_print(const std::string& fault, FaultCode expected) {
    SCOPED_TRACE(fault);
    auto settings = session_plant();
    settings.stick_bytes_per_second = 1e5;  // about 100 kB take 1 s
    if (!fault.empty()) settings.faults.push_back(parse_fault(fault).value());
    DaemonRig rig(settings);
    rig.put_scan("ball.ply");
    rig.plant.wait(std::chrono::milliseconds(1));  // lets faults that are due at 0 s start
    rig.plant.plug_stick(rig.stick());
    const auto end = [&rig] { rig.plant.press(EventKind::kShutdownRequested); };
    rig.user.on_printed = end;
    rig.user.on_words.emplace("PL-1", end);
    EXPECT_TRUE(rig.run());
    EXPECT_EQ(static_cast<int>(rig.fault), static_cast<int>(expected));
    EXPECT_EQ(rig.arena.used(), 0U);
    if (expected != FaultCode::kNone) {
      EXPECT_TRUE(rig.user.reports.empty());
      EXPECT_TRUE(rig.plant.lights().empty()) << "nothing was lit";
      return std::nullopt;
    }
    EXPECT_EQ(rig.user.reports.size(), 1U);
    if (rig.user.reports.size() != 1 || rig.plant.lights().empty()) return std::nullopt;
    EXPECT_EQ(rig.user.reports[0].state, kFinished) << rig.user.reports[0].fault_message.c_str();
    return std::chrono::duration<double>(rig.plant.lights().front().began - TimePoint()).count();
  }
};

TEST_P(EveryStickFault, WhileTheScanIsRead) {
  const StickRow& row = GetParam();
  // A stick must be there before it can be pulled; the other faults start at once.
  const bool pulled = row.code == FaultCode::kStickGone;
  const auto began = time_to_print(std::string(row.fault) + (pulled ? "@t=0.5s" : "@t=0s"), row.code);
  if (row.code != FaultCode::kNone) return;
  const auto undisturbed = time_to_print("", FaultCode::kNone);
  ASSERT_TRUE(began && undisturbed);
  EXPECT_NEAR(*began - *undisturbed, row.seconds, 20);
}

TEST_P(EveryStickFault, DoesNotDisturbAPrintWhoseScanHasBeenRead) {
  time_to_print(std::string(GetParam().fault) + "@layer=3", FaultCode::kNone);
}

INSTANTIATE_TEST_SUITE_P(Hil, EveryStickFault, ::testing::ValuesIn(kStickRows), [](const auto& row) {
  std::string name = row.param.fault;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(Faults, OfThePlantAreAllInTheTables) {
  for (const auto& known : fault_table()) {
    const auto is_it = [&](const auto& row) { return row.fault == known.name; };
    EXPECT_TRUE(std::any_of(std::begin(kRows), std::end(kRows), is_it) ||
                std::any_of(std::begin(kStickRows), std::end(kStickRows), is_it))
        << known.name;
  }
}

TEST(Faults, LostStepsAreFoundWhenThePartIsRaised) {
  auto settings = rig_plant();
  settings.faults.push_back(parse_fault("stage.skips@layer=20,by=0.2").value());
  Rig rig(settings);
  const auto& report = rig.run();
  EXPECT_NEAR(std::abs(report.steps_lost.millimetres()), 0.2, 0.005);
  std::string warnings;
  for_each_warning(report, [&](const Told&, std::string_view text) { warnings += text; });
  EXPECT_NE(warnings.find("PL-405"), std::string::npos) << warnings;
}

}  // namespace fault_test
}  // namespace plumbline::firmware
