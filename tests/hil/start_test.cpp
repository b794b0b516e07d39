/// Who starts a print and when, and the plate after it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::_;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using enum PrintState;

/// A printer as its users have it, with a stick in when it starts.
class RequestRig : public DaemonRig {
 public:
  explicit RequestRig(const PlantSettings& settings = session_plant()) : DaemonRig(settings) {
    start = StartChoice::kOnRequest;
    put_scan("ball.ply");
    plant.plug_stick(stick());
  }
  void press_at(const char* words, EventKind button) {
    user.on_words.emplace(words, [this, button] { plant.press(button); });
  }
  void end_after(nanoseconds time) {
    plant.timeline().at(plant.now() + time, [this] { plant.press(EventKind::kShutdownRequested); });
  }
  std::size_t times_said(std::string_view words) const {
    return static_cast<std::size_t>(std::count_if(user.said.begin(), user.said.end(), [&](const std::string& line) {
      return line.find(words) != std::string::npos;
    }));
  }
};

TEST(Start, LeavesAStickThatIsInAtTheStartUntilSomebodyPressesStart) {
  RequestRig rig;
  auto light = LightState::kOff;
  rig.user.on_words.emplace("Press start", [&] { light = rig.light(PanelLight::kAttention); });
  rig.end_after(10min);
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, ElementsAre("ball.ply. Press start to print it", "shut down"));
  EXPECT_EQ(light, LightState::kBlinking);
  EXPECT_TRUE(rig.user.states.empty());

  rig.press_at("ball.ply. Press start", EventKind::kStartPressed);
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 1U);
  EXPECT_EQ(rig.user.reports[0].state, kFinished) << rig.user.reports[0].fault_message.c_str();
}

TEST(Start, OffersAStickThatABadContactDroppedForASecondAgain) {
  RequestRig rig;
  write_text(rig.stick() + "/job.toml", "[job]\nscan = 'ball.ply'\n");
  rig.plant.timeline().at(TimePoint() + 5s, [&] { rig.plant.pull_stick(); });
  rig.plant.timeline().at(TimePoint() + 6s, [&] { rig.plant.plug_stick(rig.stick()); });
  rig.end_after(10min);
  ASSERT_TRUE(rig.run());
  EXPECT_EQ(rig.times_said("job.toml asks for ball.ply. Press start to print it"), 2U);
  EXPECT_TRUE(rig.user.states.empty());
  EXPECT_EQ(rig.fault, FaultCode::kNone);
}

TEST(Start, LeavesADeclinedStickUntilStartIsPressedAgain) {
  RequestRig rig;
  int times = 0;
  rig.user.on_words.emplace("ball.ply. Press start", [&] {
    rig.plant.press(times++ == 0 ? EventKind::kCancelPressed : EventKind::kShutdownRequested);
  });
  rig.press_at("ready", EventKind::kStartPressed);
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, ElementsAre("ball.ply. Press start to print it", "ready",
                                         "ball.ply. Press start to print it", "shut down"));
}

TEST(Start, WaitsAfterAPrintUntilSomebodyConfirmsThePlateAlsoAcrossRestarts) {
  RequestRig rig;
  rig.press_at("ball.ply. Press start", EventKind::kStartPressed);
  rig.user.on_printed = [&] {
    // What does not confirm it: another stick, and other buttons.
    rig.plant.pull_stick();
    rig.plant.plug_stick(rig.stick());
    rig.plant.press(EventKind::kCancelPressed);
    rig.plant.press(EventKind::kPausePressed);
    rig.end_after(10min);
  };
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 1U);
  EXPECT_EQ(rig.user.reports[0].state, kFinished);
  EXPECT_EQ(rig.light(PanelLight::kAttention), LightState::kOn);
  EXPECT_EQ(rig.light(PanelLight::kReady), LightState::kOff);
  EXPECT_FALSE(rig.plate_is_empty());

  rig.user.said.clear();
  rig.end_after(10min);
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, ElementsAre(HasSubstr("is the plate empty?"), "shut down"));

  rig.user.said.clear();
  rig.press_at("is the plate empty?", EventKind::kStartPressed);
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, ElementsAre(HasSubstr("is the plate empty?"), HasSubstr("Press start"),
                                         HasSubstr("reading"), _, _, HasSubstr("is the plate empty?"), "shut down"));
  EXPECT_EQ(rig.user.reports.size(), 2U);
}

TEST(Start, PrintsAStickOfARigThatWasChangedBeforeThePlateWasConfirmed) {
  DaemonRig rig;
  rig.put_scan("first.ply");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_printed = [&] {
    if (rig.user.reports.size() == 2) return rig.plant.press(EventKind::kShutdownRequested);
    rig.plant.pull_stick();
    std::filesystem::rename(rig.stick() + "/first.ply", rig.stick() + "/second.ply");
    rig.plant.plug_stick(rig.stick());
    rig.plant.timeline().at(rig.plant.now() + 10s, [&] { rig.plant.press(EventKind::kStartPressed); });
  };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.scans, ElementsAre("first.ply", "second.ply"));
}

TEST(Start, TakesTwoQuickPressesForOne) {
  RequestRig rig;
  ASSERT_TRUE(MachineRecord::open(rig.state(), 1)->take_plate());
  rig.user.on_words.emplace("is the plate empty?", [&] {
    rig.plant.press(EventKind::kStartPressed);
    rig.plant.timeline().at(rig.plant.now() + 500ms, [&] { rig.plant.press(EventKind::kStartPressed); });
    rig.end_after(10min);
  });
  ASSERT_TRUE(rig.run());
  EXPECT_TRUE(rig.plate_is_empty());
  EXPECT_EQ(rig.times_said("ball.ply. Press start"), 1U);
  EXPECT_TRUE(rig.user.states.empty()) << "the second press did not start a print";
}

TEST(Start, AsksForThePlateAlsoAfterACancelledPrintAndAFault) {
  auto settings = session_plant();
  settings.faults.push_back(parse_fault("panel.dead@layer=5").value());
  RequestRig rig(settings);
  rig.press_at("ball.ply. Press start", EventKind::kStartPressed);
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kStartPressed); };  // seen
  rig.press_at("an interrupted print can go on", EventKind::kCancelPressed);
  rig.press_at("is the plate empty?", EventKind::kShutdownRequested);
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 1U);
  EXPECT_EQ(rig.user.reports[0].fault, FaultCode::kPanelFailed);
  EXPECT_EQ(rig.times_said("is the plate empty?"), 1U);

  RequestRig other;
  other.press_at("ball.ply. Press start", EventKind::kStartPressed);
  other.plant.timeline().at(TimePoint() + 5min, [&] { other.plant.press(EventKind::kCancelPressed); });
  other.press_at("is the plate empty?", EventKind::kShutdownRequested);
  ASSERT_TRUE(other.run());
  ASSERT_EQ(other.user.reports.size(), 1U);
  EXPECT_EQ(other.user.reports[0].state, kCancelled);
  EXPECT_EQ(other.times_said("is the plate empty?"), 1U);
}

TEST(Start, APrintThatItsChecksRefuseIsNotInterrupted) {
  auto settings = session_plant();
  settings.faults.push_back(parse_fault("cover.opens@t=0s").value());
  RequestRig rig(settings);
  rig.press_at("ball.ply. Press start", EventKind::kStartPressed);
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 1U);
  EXPECT_EQ(rig.user.reports[0].fault, FaultCode::kCoverOpen);
  EXPECT_TRUE(rig.plate_is_empty()) << "nothing moved";
  rig.end_after(10min);
  rig.user.on_words.clear();
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, Each(Not(HasSubstr("interrupted"))));
}

TEST(Start, APrintThatWasStoredAndNotBegunIsNotInterrupted) {
  RequestRig rig;
  {
    auto store = JobStore::open(rig.state());
    const BoardFile board = session_board();
    const MachineFile machine = rig_machine();
    PrintSession session(board, machine, rig.arena, &*store);
    auto scan = FileSource::open(rig.stick() + "/ball.ply");
    ASSERT_TRUE(slice_into(session, *scan, slicing_for(board), std::nullopt, rig_profile(), machine, rig.arena));
    ASSERT_TRUE(store->has_job()) << "the power goes here";
  }
  rig.press_at("ball.ply. Press start", EventKind::kShutdownRequested);
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, ElementsAre("ball.ply. Press start to print it", "shut down"));
}

/// A printer whose profile has a say about the small foot of a ball.
class StrictRig : public RequestRig {
 public:
  explicit StrictRig(const std::string& action) {
    std::filesystem::create_directory(folder / "profiles");
    std::string text = read_text(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml");
    const std::string usual = "first_layer_area = \"warn\"";
    text.replace(text.find(usual), usual.size(), "first_layer_area = \"" + action + "\"");
    const std::string supported = "supports_enable = true";  // the raft of a supported ball is large enough
    text.replace(text.find(supported), supported.size(), "supports_enable = false");
    write_text(folder / "profiles/standard.toml", text);
    board_path = folder / "sim2k.toml";
    press_at("ball.ply. Press start", EventKind::kStartPressed);
    user.on_printed = [this] { plant.press(EventKind::kShutdownRequested); };
  }
};

TEST(Start, WaitsForASecondStartIfTheProfileAsksAboutAnIssue) {
  StrictRig rig("ask");
  rig.press_at("Press start to print it all the same", EventKind::kStartPressed);
  ASSERT_TRUE(rig.run());
  EXPECT_EQ(rig.times_said("1 small first layer of "), 1U);
  EXPECT_EQ(rig.times_said("Found in the layers: "), 1U);
  ASSERT_EQ(rig.user.reports.size(), 1U);
  EXPECT_EQ(rig.user.reports[0].state, kFinished) << rig.user.reports[0].fault_message.c_str();
  EXPECT_EQ(rig.user.reports[0].checks[static_cast<std::size_t>(Check::kMasks)].outcome, CheckOutcome::kWarned);
}

TEST(Start, PrintsNothingIfTheSecondStartDoesNotCome) {
  StrictRig rig("ask");
  rig.press_at("Press start to print it all the same", EventKind::kCancelPressed);
  rig.press_at("ready", EventKind::kShutdownRequested);
  ASSERT_TRUE(rig.run());
  EXPECT_TRUE(rig.user.states.empty());
  EXPECT_EQ(rig.fault, FaultCode::kNone);
  EXPECT_TRUE(rig.plate_is_empty());
}

TEST(Start, RefusesWhatTheProfileRefuses) {
  StrictRig rig("refuse");
  rig.press_at("PL-111, issue in the layers", EventKind::kShutdownRequested);
  ASSERT_TRUE(rig.run());
  EXPECT_EQ(rig.times_said("PL-111, issue in the layers"), 1U);
  EXPECT_TRUE(rig.user.states.empty());
  EXPECT_EQ(rig.fault, FaultCode::kIssueFound);
}

}  // namespace
}  // namespace plumbline::firmware
