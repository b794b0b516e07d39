/// Buttons and touches on the screen, and when it is drawn.

#include "firmware/screen/screen_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "firmware/screen/light_card.hpp"
#include "firmware/screen/remedy_rows.hpp"
#include "firmware/screen/screen_kind.hpp"
#include "firmware/screen/setting_rows.hpp"
#include "tests/firmware/screen/screen_fixture.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using enum PrintState;
using enum EventKind;

class TestScreen final : public StatusScreen {
 public:
  TestScreen() : StatusScreen(320, 240) {}
  std::uint32_t frames = 0;
  bool fails = false;
  std::optional<ScreenTouch> touch;

 private:
  Status do_present(std::span<const std::uint16_t> /*pixels*/) override {
    if (fails) return fail(ErrorCode::kPanelFailed, "the screen does not answer");
    ++frames;
    return {};
  }
  std::optional<ScreenTouch> do_next_touch() override { return std::exchange(touch, std::nullopt); }
};

/// Keeps what it is asked for, and carries out what changes the record's job.
class TestTaker final : public CommandTaker {
 public:
  explicit TestTaker(PrinterRecord& record) : record_(record) {}
  Expected<std::optional<EventKind>> take(const ClientRequest& request) override {
    if (request.command == Command::kRemove) {
      taken.push_back("remove " + std::string(request.name.view()));
      record_.stored.reset();
      return kCancelPressed;
    }
    if (request.command == Command::kSettings) {
      taken.push_back("settings");
      return kCancelPressed;
    }
    if (request.command == Command::kPropose) {
      taken.push_back("propose");
      return kStartPressed;
    }
    if (request.command == Command::kOpen) {
      taken.push_back("open " + std::to_string(request.folder));
      return kStartPressed;
    }
    if (request.command == Command::kChoose) {
      taken.push_back("choose " + std::to_string(request.scan));
      record_.job->chosen = request.scan - 1;
    } else {
      taken.push_back("set " + std::string(request.key.view()) + "=" + std::string(request.value.view()));
      if (slices_again) return kCancelPressed;
    }
    return std::nullopt;
  }
  std::vector<std::string> taken;
  bool slices_again = false;  ///< with each value

 private:
  PrinterRecord& record_;
};

struct Rig {
  explicit Rig(PrintState state) { fill_in(*record, state); }
  /// Whether the printer gets the event.
  bool press(EventKind kind, nanoseconds at = 0s) {
    const auto passed = server.filter({TimePoint() + at, kind}, *record, taker);
    EXPECT_TRUE(!passed || passed->kind == kind);
    return passed.has_value();
  }
  std::unique_ptr<PrinterRecord> record = std::make_unique<PrinterRecord>();
  TestTaker taker{*record};
  TestScreen screen;
  ScreenServer server{screen, Language::kEnglish};
};

TEST(ScreenServer, AsksBeforeItCancelsAPrint) {
  Rig rig(kPrinting);
  EXPECT_FALSE(rig.press(kCancelPressed, 10s));
  EXPECT_TRUE(rig.server.view().asks_to_cancel);
  EXPECT_FALSE(rig.press(kCancelPressed, 10s + 500ms)) << "a press that was meant for the screen before";
  EXPECT_FALSE(rig.press(kStartPressed, 12s));
  EXPECT_FALSE(rig.server.view().asks_to_cancel) << "the print goes on";
  EXPECT_FALSE(rig.press(kCancelPressed, 20s));
  EXPECT_FALSE(rig.press(kPausePressed, 22s)) << "it does nothing while the question is open";
  EXPECT_TRUE(rig.press(kCancelPressed, 22s));
  EXPECT_FALSE(rig.server.view().asks_to_cancel);
}

TEST(ScreenServer, ForgetsItsQuestionWhenThePrintEndsByItself) {
  Rig rig(kPrinting);
  rig.press(kCancelPressed, 10s);
  rig.record->state = kFinishing;
  rig.server.show(*rig.record, 1h);
  EXPECT_FALSE(rig.server.view().asks_to_cancel);
  EXPECT_TRUE(rig.press(kCancelPressed, 20s)) << "the printer knows what to make of it";
}

TEST(ScreenServer, LetsAPauseAndAResumeThrough) {
  Rig rig(kPrinting);
  EXPECT_TRUE(rig.press(kPausePressed));
  rig.record->state = kPaused;
  EXPECT_TRUE(rig.press(kStartPressed));
  EXPECT_TRUE(rig.press(kCoverOpened));
}

TEST(ScreenServer, ShowsTheLastPrintsWhileThePrinterIsIdle) {
  Rig rig(kIdle);
  EXPECT_TRUE(rig.press(kPausePressed)) << "there are none";
  rig.record->prints = &some_prints();
  EXPECT_FALSE(rig.press(kPausePressed));
  EXPECT_TRUE(rig.server.view().prints_open);
  for (std::size_t i = 1; i <= some_prints().list().size(); ++i) {
    EXPECT_FALSE(rig.press(kPausePressed));
    EXPECT_EQ(rig.server.view().print, i % some_prints().list().size());
  }
  EXPECT_FALSE(rig.press(kStartPressed)) << "nothing is printed from here";
  EXPECT_FALSE(rig.press(kCancelPressed));
  EXPECT_FALSE(rig.server.view().prints_open);
  rig.press(kPausePressed);
  rig.record->state = kOffered;
  rig.server.show(*rig.record, 1h);
  EXPECT_FALSE(rig.server.view().prints_open) << "a stick has come";
}

TEST(KeptPreview, IsThePictureThatWasKept) {
  auto preview = KeptPreview::create();
  ASSERT_TRUE(preview);
  const PreviewPicture& ball = ball_pictures().preview;
  for (const std::uint32_t number : {1U, 5U, 5U, 1U}) {
    const PreviewPicture* const picture = preview->of(some_prints(), number);
    ASSERT_NE(picture, nullptr);
    EXPECT_EQ(picture->columns, ball.columns);
    EXPECT_TRUE(std::ranges::equal(picture->bytes(), ball.bytes()));
    EXPECT_EQ(preview->of(some_prints(), 3), nullptr) << "a resumed print";
    EXPECT_EQ(preview->of(some_prints(), 6), nullptr) << "no print";
  }
}

TEST(ScreenServer, DrawsAnotherCodeForAnotherAddress) {
  Rig rig(kIdle);
  assign(rig.record->address, "http://192.168.1.2:8080");
  rig.server.show(*rig.record, 1h);
  const auto next = [&](std::string_view address) {
    assign(rig.record->address, address);
    rig.press(kCancelPressed);  // opens the card of lights, so that the next frame is due at once
    rig.press(kCancelPressed);
    rig.server.show(*rig.record, 1h);
    return rig.screen.frames;
  };
  EXPECT_EQ(next("http://192.168.1.2:8080"), 1U);
  EXPECT_EQ(next("http://192.168.1.3:8080"), 2U);
  EXPECT_EQ(next(""), 3U);
}

TEST(ScreenServer, ShowsTheCardOfLightsWhileNobodyIsInAHurry) {
  Rig rig(kPlateInUse);
  EXPECT_FALSE(rig.press(kCancelPressed));
  ASSERT_TRUE(rig.server.view().lights_open);
  const std::size_t now = light_pattern_of(kPlateInUse);
  EXPECT_EQ(rig.server.view().pattern, now) << "it begins with the lights of this moment";
  EXPECT_FALSE(rig.press(kStartPressed)) << "the plate is not empty because somebody has read the card";
  for (std::size_t i = 1; i <= kLightPatternCount; ++i) {
    EXPECT_FALSE(rig.press(kPausePressed));
    EXPECT_EQ(rig.server.view().pattern, (now + i) % kLightPatternCount);
  }
  EXPECT_FALSE(rig.press(kCancelPressed));
  EXPECT_FALSE(rig.server.view().lights_open);
  EXPECT_TRUE(rig.press(kStartPressed));
  rig.record->state = kIdle;
  rig.press(kCancelPressed);
  EXPECT_TRUE(rig.server.view().lights_open);
  rig.record->state = kOffered;
  rig.server.show(*rig.record, 1h);
  EXPECT_FALSE(rig.server.view().lights_open) << "a stick has come";
}

TEST(ScreenServer, GoesRoundTheScansAndTheSettings) {
  Rig rig(kOffered);
  EXPECT_FALSE(rig.press(kPausePressed));
  EXPECT_FALSE(rig.press(kPausePressed));
  EXPECT_THAT(rig.taker.taken, ElementsAre("choose 2", "choose 3"));
  EXPECT_FALSE(rig.press(kPausePressed));
  EXPECT_EQ(rig.server.view().row, ListRow::kSettings);
  EXPECT_FALSE(rig.press(kPausePressed));
  EXPECT_THAT(rig.taker.taken, ElementsAre("choose 2", "choose 3", "choose 1"));
  EXPECT_TRUE(rig.press(kStartPressed)) << "prints the first one";
  EXPECT_TRUE(rig.press(kCancelPressed));
}

TEST(ScreenServer, OpensFoldersAndGoesBackUp) {
  Rig rig(kOffered);
  rig.record->folder_count = 2;
  assign(rig.record->folder, "prints");
  rig.record->job->chosen = 2;
  for (const ListRow row : {ListRow::kFolder, ListRow::kFolder, ListRow::kUp, ListRow::kSettings}) {
    EXPECT_FALSE(rig.press(kPausePressed));
    EXPECT_EQ(rig.server.view().row, row);
    EXPECT_TRUE(rig.taker.taken.empty());
  }
  rig.press(kPausePressed);
  EXPECT_THAT(rig.taker.taken, ElementsAre("choose 1"));
  rig.record->job->chosen = 2;
  rig.press(kPausePressed);
  rig.press(kPausePressed);
  EXPECT_EQ(rig.server.view().folder, 1U);
  const auto passed = rig.server.filter({TimePoint(), kStartPressed}, *rig.record, rig.taker);
  ASSERT_TRUE(passed) << "as the start of a wish";
  EXPECT_TRUE(passed->named) << "or it would not count within a second of the choice before it";
  EXPECT_EQ(rig.server.view().row, ListRow::kScan);
  for (int i = 0; i < 3; ++i) rig.press(kPausePressed);
  EXPECT_TRUE(rig.press(kStartPressed));
  EXPECT_THAT(rig.taker.taken, ElementsAre("choose 1", "open 2", "open 0"));
  // The list of another folder, or another stick, has fewer of them.
  for (int i = 0; i < 2; ++i) rig.press(kPausePressed);
  EXPECT_EQ(rig.server.view().folder, 1U);
  rig.record->folder_count = 1;
  rig.server.show(*rig.record, 1h);
  EXPECT_EQ(rig.server.view().row, ListRow::kScan);
}

TEST(ScreenServer, AsksBeforeItDeletesAnUploadedScan) {
  Rig rig(kOffered);
  rig.record->scan_count = 1;
  assign(rig.record->stored.emplace().name, "bust.ply");
  EXPECT_FALSE(rig.press(kPausePressed, 10s));
  EXPECT_FALSE(rig.press(kPausePressed, 11s));
  EXPECT_EQ(rig.server.view().row, ListRow::kScan) << "what is offered is on a stick";
  rig.record->scans_uploaded = true;
  EXPECT_FALSE(rig.press(kPausePressed, 12s));
  EXPECT_FALSE(rig.press(kPausePressed, 13s));
  ASSERT_EQ(rig.server.view().row, ListRow::kRemove);
  EXPECT_FALSE(rig.press(kStartPressed, 14s)) << "it asks, and prints nothing";
  ASSERT_TRUE(rig.server.view().asks_to_remove);
  EXPECT_FALSE(rig.press(kCancelPressed, 14s + 500ms)) << "a press that was meant for the screen before";
  EXPECT_FALSE(rig.press(kPausePressed, 16s));
  EXPECT_FALSE(rig.press(kStartPressed, 16s)) << "back";
  EXPECT_FALSE(rig.server.view().asks_to_remove);
  EXPECT_THAT(rig.taker.taken, ElementsAre());
  EXPECT_FALSE(rig.press(kStartPressed, 20s));
  EXPECT_TRUE(rig.press(kCancelPressed, 22s)) << "what was offered is gone, which the printer has to know";
  EXPECT_THAT(rig.taker.taken, ElementsAre("remove bust.ply"));
  rig.server.show(*rig.record, 1h);
  EXPECT_EQ(rig.server.view().row, ListRow::kScan);
  EXPECT_FALSE(rig.server.view().asks_to_remove);
}

TEST(ScreenServer, GoesBackFromWhatHasBeenSlicedToItsSettings) {
  Rig rig(kOffered);
  rig.record->scan_count = 1;
  rig.record->sliced = a_sliced_job();
  EXPECT_FALSE(rig.press(kPausePressed));
  ASSERT_TRUE(rig.server.view().contract_open);
  const auto passed = rig.server.filter({TimePoint(), kStartPressed}, *rig.record, rig.taker);
  ASSERT_TRUE(passed) << "the question is over";
  EXPECT_TRUE(passed->kind == kCancelPressed && passed->named) << "also within a second of it";
  EXPECT_THAT(rig.taker.taken, ElementsAre("settings"));
  rig.record->sliced.reset();
  rig.server.show(*rig.record, 1h);
  EXPECT_TRUE(rig.server.view().settings_open);
  // A value with which it is sliced again ends the question, too.
  rig.record->sliced = a_sliced_job();
  rig.server.show(*rig.record, 1h);
  EXPECT_FALSE(rig.press(kPausePressed));
  for (std::size_t row = 0; row <= index_of(PrintKey::kExposureTime); ++row) EXPECT_FALSE(rig.press(kCancelPressed));
  rig.taker.slices_again = true;
  const auto again = rig.server.filter({TimePoint(), kStartPressed}, *rig.record, rig.taker);
  EXPECT_TRUE(again && again->kind == kCancelPressed && again->named);
  EXPECT_THAT(rig.taker.taken.back(), testing::StartsWith("set exposure_time="));
  rig.record->state = kSlicing;
  rig.server.show(*rig.record, 1h);
  rig.record->state = kOffered;
  rig.taker.taken.clear();
  // Without its scan there are only the values.
  rig.record->sliced = a_sliced_job();
  rig.record->has_stick = false;
  rig.server.show(*rig.record, 1h);
  EXPECT_FALSE(rig.press(kPausePressed));
  ASSERT_TRUE(rig.server.view().contract_open);
  EXPECT_FALSE(rig.press(kStartPressed));
  for (std::size_t row = 1; row < kContractRows; ++row) {
    EXPECT_EQ(rig.server.view().value, row);
    EXPECT_FALSE(rig.press(kCancelPressed));
  }
  EXPECT_FALSE(rig.server.view().contract_open);
  EXPECT_THAT(rig.taker.taken, ElementsAre());
}

/// Two findings of what has been sliced, the first with two remedies.
void find_two(PrinterRecord& record) {
  record.sliced = a_sliced_job();
  Remedies remedies;
  remedies.add("units", "cm");
  remedies.add("units", "m");
  record.add_finding(Severity::kWarning, "an issue", {}, remedies);
  record.add_finding(Severity::kWarning, "another one");
}

TEST(ScreenServer, MendsAFindingByButtons) {
  Rig rig(kOffered);
  find_two(*rig.record);
  EXPECT_FALSE(rig.press(kPausePressed));
  ASSERT_TRUE(rig.server.view().remedies_open);
  EXPECT_FALSE(rig.press(kPausePressed));
  rig.taker.slices_again = true;
  const auto again = rig.server.filter({TimePoint(), kStartPressed}, *rig.record, rig.taker);
  EXPECT_TRUE(again && again->kind == kCancelPressed && again->named) << "the question is over: it is sliced again";
  EXPECT_THAT(rig.taker.taken, ElementsAre("set units=m"));
  EXPECT_FALSE(rig.server.view().remedies_open);
}

TEST(ScreenServer, LeavesAFindingAsItIsByTheLastRow) {
  Rig rig(kOffered);
  find_two(*rig.record);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(rig.press(kPausePressed));
  EXPECT_EQ(rig.server.view().remedy, 2U);
  EXPECT_FALSE(rig.press(kStartPressed)) << "this prints nothing";
  EXPECT_FALSE(rig.server.view().remedies_open);
  EXPECT_EQ(rig.server.view().finding, 1U);
  EXPECT_TRUE(rig.press(kStartPressed)) << "the preview prints";
  EXPECT_FALSE(rig.press(kPausePressed)) << "the second one has no remedy";
  EXPECT_TRUE(rig.server.view().contract_open);
  EXPECT_THAT(rig.taker.taken, ElementsAre());
}

TEST(ScreenServer, MendsNothingThatCannotBeSlicedAgain) {
  Rig rig(kOffered);
  find_two(*rig.record);
  rig.press(kPausePressed);
  rig.record->has_stick = false;
  EXPECT_FALSE(rig.press(kPausePressed)) << "goes on to the next one";
  EXPECT_FALSE(rig.server.view().remedies_open);
  EXPECT_EQ(rig.server.view().finding, 1U);
}

TEST(ScreenServer, MendsAFindingByATouch) {
  Rig rig(kOffered);
  find_two(*rig.record);
  rig.taker.slices_again = true;
  const auto touch = [&](int row) {
    rig.screen.touch = ScreenTouch{TimePoint() + 5s, 100, static_cast<std::uint32_t>(row)};
    return rig.server.touched(*rig.record, rig.taker);
  };
  const Look look(320, 240);
  const PixelBox box = remedy_row_box(look, {0, 0, 320, 240}, 3, 0);
  EXPECT_FALSE(touch(box.y + 1)) << "the rows are not there yet";
  EXPECT_THAT(rig.taker.taken, ElementsAre());
  rig.press(kPausePressed);
  EXPECT_FALSE(touch(box.y - 1)) << "above them";
  EXPECT_THAT(rig.taker.taken, ElementsAre());
  const auto again = touch(box.y + box.height);
  EXPECT_TRUE(again && again->kind == kCancelPressed && again->named);
  EXPECT_THAT(rig.taker.taken, ElementsAre("set units=m"));
}

TEST(ScreenServer, ChangesEachSettingByOneButton) {
  Rig rig(kOffered);
  rig.record->scan_count = 1;
  EXPECT_FALSE(rig.press(kPausePressed));
  EXPECT_FALSE(rig.press(kStartPressed));
  ASSERT_TRUE(rig.server.view().settings_open);
  for (std::size_t row = 0; row < kMostSettingRows; ++row) {
    if (!opens_proposals(row)) {
      EXPECT_FALSE(rig.press(kStartPressed));
    }
    EXPECT_FALSE(rig.press(kPausePressed));
  }
  EXPECT_THAT(rig.taker.taken, ElementsAre("set profile=draft", "set height=20mm", "set rotate_z_deg=90",
                                           "set rotate_x_deg=90", "set supports=auto", "set layer_height=0.025"));
  EXPECT_FALSE(rig.press(kCancelPressed));
  EXPECT_FALSE(rig.server.view().settings_open);
}

// Regression: every other setting of an archive was taken, and then its print was refused for it.
TEST(ScreenServer, ChangesOnlyTheProfileOfAnArchive) {
  Rig rig(kOffered);
  rig.record->scan_count = 1;
  assign(rig.record->job->files[0], "bust.sl1");
  EXPECT_FALSE(rig.press(kPausePressed));
  EXPECT_FALSE(rig.press(kStartPressed));
  ASSERT_TRUE(rig.server.view().settings_open);
  for (int times = 0; times < 2; ++times) {
    EXPECT_FALSE(rig.press(kStartPressed));
    EXPECT_FALSE(rig.press(kPausePressed));
  }
  EXPECT_THAT(rig.taker.taken, ElementsAre("set profile=draft", "set profile=draft"));
}

/// Opens the settings and goes to the row of the best ways up.
void go_to_the_ways(Rig& rig) {
  rig.record->scan_count = 1;
  EXPECT_FALSE(rig.press(kPausePressed));
  EXPECT_FALSE(rig.press(kStartPressed));
  for (int row = 0; row < 4; ++row) EXPECT_FALSE(rig.press(kPausePressed));
  ASSERT_TRUE(opens_proposals(rig.server.view().setting));
}

TEST(ScreenServer, WaitsForTheBestWaysUpThenTakesOneOfThem) {
  Rig rig(kOffered);
  go_to_the_ways(rig);
  EXPECT_TRUE(rig.press(kStartPressed)) << "the daemon looks for them";
  EXPECT_THAT(rig.taker.taken, ElementsAre("propose"));
  rig.record->state = kSlicing;
  rig.record->slicing = SlicingRecord{Stage::kTrees, 0.5, true};
  rig.server.show(*rig.record, 1h);
  EXPECT_FALSE(rig.press(kStartPressed));
  rig.record->state = kOffered;
  rig.record->slicing.reset();
  rig.record->proposals = some_proposals();
  rig.server.show(*rig.record, 1h);
  ASSERT_TRUE(rig.server.view().proposals_open);
  EXPECT_EQ(rig.server.view().proposal, 1U) << "the best";
  for (const std::size_t row : {2U, 3U, 4U, 0U, 1U, 2U}) {
    EXPECT_FALSE(rig.press(kPausePressed));
    EXPECT_EQ(rig.server.view().proposal, row);
  }
  EXPECT_FALSE(rig.press(kStartPressed));
  EXPECT_THAT(rig.taker.taken, ElementsAre("propose", "set proposal=2"));
  EXPECT_FALSE(rig.server.view().proposals_open);
  EXPECT_TRUE(rig.server.view().settings_open);
  // They are known now: nothing is read again. The one that the job has is at hand.
  rig.record->job->rotate_x_deg = -65;
  rig.record->job->rotate_y_deg = 10.5;
  EXPECT_FALSE(rig.press(kStartPressed));
  EXPECT_EQ(rig.server.view().proposal, 2U);
  EXPECT_FALSE(rig.press(kCancelPressed));
  EXPECT_FALSE(rig.server.view().proposals_open);
  EXPECT_EQ(rig.taker.taken.size(), 2U) << "back changes nothing";
}

TEST(ScreenServer, GoesBackToTheSettingsIfTheBestWaysUpAreGivenUp) {
  Rig rig(kOffered);
  go_to_the_ways(rig);
  EXPECT_TRUE(rig.press(kStartPressed));
  rig.record->state = kSlicing;
  rig.record->slicing = SlicingRecord{Stage::kRead, 0.5, true};
  EXPECT_TRUE(rig.press(kCancelPressed)) << "the daemon stops";
  rig.record->state = kOffered;
  rig.record->slicing.reset();
  rig.server.show(*rig.record, 1h);
  EXPECT_FALSE(rig.server.view().proposals_open);
  EXPECT_TRUE(rig.server.view().settings_open);
}

TEST(ScreenServer, BringsEachSettingBackAfterAWhile) {
  PrinterRecord record;
  fill_in(record, kOffered);
  JobRecord& job = *record.job;
  const auto next = [&](std::size_t row) { return std::string(next_value(row, record, job).value.view()); };
  assign(job.profile, "standard");
  EXPECT_EQ(next(0), "draft") << "the first one follows the last one";
  job.size = PrintSize{Side::kHeight, 150};
  EXPECT_EQ(next_value(1, record, job).key.view(), "scale");
  job.rotate_z_deg = -90;
  EXPECT_EQ(next(2), "0");
  job.rotate_x_deg = 270;
  EXPECT_EQ(next(3), "0");
  job.supports.enable = false;
  EXPECT_EQ(next(5), "");
  job.layer_height = 0.1;
  EXPECT_EQ(next(6), "adaptive");
  job.layer_height = kAdaptiveHeight;
  EXPECT_EQ(next(6), "");
}

TEST(ScreenServer, TakesATouchOfABottomThirdAsItsButton) {
  Rig rig(kPaused);
  const auto touch = [&](std::uint32_t column, std::uint32_t row) {
    rig.screen.touch = ScreenTouch{TimePoint() + 5s, column, row};
    const auto event = rig.server.touched(*rig.record, rig.taker);
    return event ? std::optional(event->kind) : std::nullopt;
  };
  EXPECT_EQ(touch(10, 230), kStartPressed);
  EXPECT_EQ(touch(160, 230), kPausePressed);
  EXPECT_EQ(touch(310, 100), std::nullopt) << "above the buttons";
  EXPECT_EQ(touch(310, 239), std::nullopt) << "it asks first";
  EXPECT_TRUE(rig.server.view().asks_to_cancel);
}

TEST(ScreenServer, DrawsOnlyWhatHasChangedAndOnlyInSpareTime) {
  Rig rig(kPrinting);
  rig.server.show(*rig.record, ScreenServer::kSpare - 1ms);
  EXPECT_EQ(rig.screen.frames, 0U) << "something is due";
  rig.server.show(*rig.record, 1h);
  EXPECT_EQ(rig.screen.frames, 1U);
  const auto again = [&] {
    rig.press(kPausePressed);  // so that the next frame is due at once
    rig.server.show(*rig.record, 1h);
    return rig.screen.frames;
  };
  EXPECT_EQ(again(), 1U) << "nothing has changed";
  rig.record->progress->layers_done = 1200;
  rig.server.show(*rig.record, 1h);
  EXPECT_EQ(rig.screen.frames, 1U) << "the last frame was drawn just now";
  EXPECT_EQ(again(), 2U);
  rig.screen.fails = true;
  rig.record->progress->layers_done = 1300;
  EXPECT_EQ(again(), 2U);
  rig.screen.fails = false;
  EXPECT_EQ(again(), 3U) << "it is tried again";
}

// A button that the screen labels does something, and one that it does not label changes nothing on it.
TEST(ScreenServer, LabelsOnlyButtonsThatThePrinterTakes) {
  for (std::size_t i = 0; i < kPrintStateCount; ++i) {
    PrinterRecord record;
    fill_in(record, static_cast<PrintState>(i));
    const auto uses = buttons_of(record, {});
    const bool start = takes(record, Command::kStart) || takes(record, Command::kResume) ||
                       takes(record, Command::kPlateEmpty) || takes(record, Command::kSeen) ||
                       takes(record, Command::kOffer);
    EXPECT_EQ(uses[0].has_value(), start) << to_string(record.state);
    const ScreenKind kind = screen_of(record);
    const bool has_card = kind == ScreenKind::kIdle || kind == ScreenKind::kPlate;
    EXPECT_EQ(uses[2].has_value(), has_card || takes(record, Command::kCancel)) << to_string(record.state);
    if (screen_of(record) != ScreenKind::kScans) {
      EXPECT_EQ(uses[1].has_value(), takes(record, Command::kPause)) << to_string(record.state);
    }
  }
}

}  // namespace
}  // namespace plumbline::firmware
