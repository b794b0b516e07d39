/// Every fault of the plant at the start, in the middle and at the end of a print: README.md in this folder has the table.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hil/rig.hpp"

namespace plumbline {
namespace {

using enum PrintState;

/// How a print ends, and with which code.
struct End {
  PrintState state;
  FaultCode code = FaultCode::kNone;
  bool operator==(const End&) const = default;
};

constexpr End kAsIfNothing{kFinished};
constexpr End faulted(FaultCode code) { return {kFault, code}; }

/// What the plant may object to: where a fault is one that no firmware could notice or undo.
enum class May : std::uint8_t { kNothing, kObjectToItself };

struct Row {
  const char* fault;
  const char* more;  ///< of the fault's text
  End start, middle, end;
  May may = May::kNothing;
};

// A stage that stalls while it homes has met something before its end stop. Where a fault comes "in exposure" of the last layer, nothing looks at it any more.
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
    {"stick.pulled", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"stick.slow", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"stick.bad_sector", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"stick.mount_fails", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"temperature.lamp_hot", ",for=900s", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"temperature.lamp_sensor_dead", "", faulted(FaultCode::kSensorDead), faulted(FaultCode::kSensorDead),
     kAsIfNothing},
    {"temperature.resin_cold", "", faulted(FaultCode::kResinTooCold), faulted(FaultCode::kResinTooCold), kAsIfNothing},
    {"temperature.resin_hot", "", faulted(FaultCode::kResinTooWarm), faulted(FaultCode::kResinTooWarm), kAsIfNothing},
    {"temperature.resin_sensor_dead", "", faulted(FaultCode::kSensorDead), faulted(FaultCode::kSensorDead),
     kAsIfNothing},
    {"temperature.resin_sensor_wild", "", faulted(FaultCode::kSensorDead), faulted(FaultCode::kSensorDead),
     kAsIfNothing},
    {"temperature.board_hot", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
    {"fan.lamp_stalls", "", faulted(FaultCode::kFanStalled), faulted(FaultCode::kFanStalled), kAsIfNothing},
    {"fan.chamber_stalls", "", kAsIfNothing, kAsIfNothing, kAsIfNothing},
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
    if (!rig.plant.powered()) rig.plant.restore_power();  // lets the lamp's last millisecond pass
    const bool can_be_dark = std::string_view(row.fault) != "lamp.runaway";
    EXPECT_EQ(rig.plant.light(), !can_be_dark);
    EXPECT_EQ(rig.objections_of(ObjectionKind::kLightWithCoverOpen), 0U);
    EXPECT_EQ(rig.objections_of(ObjectionKind::kMotionUnderLight), 0U) << rig.objections();
    EXPECT_EQ(rig.objections_of(ObjectionKind::kMaskChangedUnderLight), 0U) << rig.objections();
    if (row.may == May::kNothing) check_objections(rig, report);
    check_journal(rig, report);
  }

  /// Of a print that ended before its end the last layer may have too little light, and nothing else may be wrong.
  static void check_objections(const Rig& rig, const PrintReport& report) {
    for (const auto& objection : rig.plant.objections()) {
      const bool unfinished =
          report.state != kFinished && objection.layer == report.next_layer &&
          (objection.kind == ObjectionKind::kDoseOff || objection.kind == ObjectionKind::kNotBonded);
      EXPECT_TRUE(unfinished) << to_string(objection);
    }
  }

  /// Nothing is lost that the user had: the journal knows every layer that was cured.
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

TEST(Faults, OfThePlantAreAllInTheTable) {
  for (const auto& known : fault_table()) {
    EXPECT_TRUE(std::any_of(std::begin(kRows), std::end(kRows), [&](const Row& row) {
      return row.fault == known.name;
    })) << known.name;
  }
}

TEST(Faults, StepsThatWereLostAreFoundWhenThePartIsRaised) {
  auto settings = rig_plant();
  settings.faults.push_back(parse_fault("stage.skips@layer=20,by=0.2").value());
  Rig rig(settings);
  const auto& report = rig.run();
  EXPECT_NEAR(std::abs(report.steps_lost.millimetres()), 0.2, 0.005);
  std::string warnings;
  for_each_warning(report, [&](std::string_view text) { warnings += text; });
  EXPECT_NE(warnings.find("PL-405"), std::string::npos) << warnings;
}

}  // namespace
}  // namespace plumbline
