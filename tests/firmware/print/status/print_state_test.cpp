#include "firmware/print/status/print_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "firmware/print/status/fault.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;
using enum PrintState;
using enum PrintEvent;

constexpr auto state_at(std::size_t index) { return static_cast<PrintState>(index); }
constexpr auto event_at(std::size_t index) { return static_cast<PrintEvent>(index); }

// An undisturbed print, at compile time.
static_assert(next(kIdle, kJobOffered) == kOffered);
static_assert(next(kOffered, kJobTaken) == kSlicing);
static_assert(next(kSlicing, kSliced) == kChecks);
static_assert(next(kChecks, kChecksPassed) == kHoming);
static_assert(next(kHoming, kHomed) == kPrinting);
static_assert(next(kPrinting, kLastLayerDone) == kFinishing);
static_assert(next(kFinishing, kRaised) == kFinished);
static_assert(next(kFinished, kAcknowledged) == kIdle);
static_assert(next(kIdle, kPlateTaken) == kPlateInUse);
static_assert(next(kPlateInUse, kPlateEmpty) == kIdle);

TEST(PrintState, EveryPairHasANextStateAndAName) {
  std::set<std::string_view> names;
  for (std::size_t s = 0; s < kPrintStateCount; ++s) {
    names.insert(to_string(state_at(s)));
    for (std::size_t e = 0; e < kPrintEventCount; ++e) {
      EXPECT_LT(static_cast<std::size_t>(next(state_at(s), event_at(e))), kPrintStateCount);
    }
  }
  EXPECT_EQ(names.size(), kPrintStateCount);
  EXPECT_FALSE(names.contains("unknown state"));
  EXPECT_EQ(to_string(state_at(kPrintStateCount)), "unknown state") << "kPrintStateCount is all of them";
  EXPECT_EQ(to_string(event_at(kPrintEventCount)), "unknown event") << "kPrintEventCount is all of them";
}

TEST(PrintState, EveryStateCanBeReachedAndLeft) {
  std::set<PrintState> reached{kIdle};
  for (std::size_t round = 0; round < kPrintStateCount; ++round) {
    for (const PrintState from : std::set<PrintState>(reached)) {
      for (std::size_t e = 0; e < kPrintEventCount; ++e) reached.insert(next(from, event_at(e)));
    }
  }
  EXPECT_EQ(reached.size(), kPrintStateCount);
  for (std::size_t s = 0; s < kPrintStateCount; ++s) {
    bool left = false;
    for (std::size_t e = 0; e < kPrintEventCount; ++e) left = left || next(state_at(s), event_at(e)) != state_at(s);
    EXPECT_TRUE(left) << to_string(state_at(s));
  }
}

TEST(PrintState, AnOpenedCoverNeedsTheUserToPrintAgain) {
  for (std::size_t s = 0; s < kPrintStateCount; ++s) {
    for (std::size_t e = 0; e < kPrintEventCount; ++e) {
      if (next(state_at(s), event_at(e)) != kPrinting || state_at(s) == kPrinting) continue;
      const bool asked = event_at(e) == kResumeAsked || event_at(e) == kHomed || event_at(e) == kCooledDown;
      EXPECT_TRUE(asked) << to_string(state_at(s)) << ", " << to_string(event_at(e));
    }
  }
  EXPECT_EQ(next(kCoverOpen, kCoverClosed), kPaused);
  EXPECT_EQ(next(kHoming, kPartInDoubt), kPaused) << "the user measures the part first";
}

TEST(PrintState, CoverCancelFailureAndShutdownEndALayer) {
  EXPECT_EQ(next(kPrinting, kCoverOpened), kCoverOpen);
  EXPECT_EQ(next(kPrinting, kCancelAsked), kCancelling);
  EXPECT_EQ(next(kPrinting, kFailed), kFault);
  EXPECT_EQ(next(kPrinting, kShutdown), kSuspended);
}

TEST(PrintState, FailureAndShutdownWorkInEveryRunningState) {
  for (std::size_t s = 0; s < kPrintStateCount; ++s) {
    if (at_rest(state_at(s))) continue;
    EXPECT_EQ(next(state_at(s), kFailed), kFault) << to_string(state_at(s));
    EXPECT_EQ(next(state_at(s), kShutdown), kSuspended) << to_string(state_at(s));
  }
}

TEST(PrintState, OnlyTheUserLeavesAStateAtRest) {
  for (const PrintState state : {kFinished, kCancelled, kSuspended, kFault}) {
    for (std::size_t e = 0; e < kPrintEventCount; ++e) {
      EXPECT_EQ(next(state, event_at(e)), event_at(e) == kAcknowledged ? kIdle : state);
    }
  }
}

TEST(PrintState, NothingButAPersonsWordLeavesAPlateInUse) {
  for (std::size_t e = 0; e < kPrintEventCount; ++e) {
    EXPECT_EQ(next(kPlateInUse, event_at(e)), event_at(e) == kPlateEmpty ? kIdle : kPlateInUse)
        << to_string(event_at(e));
  }
}

TEST(PrintState, AScanIsSlicedOnlyAfterItWasOfferedAndTaken) {
  for (std::size_t s = 0; s < kPrintStateCount; ++s) {
    for (std::size_t e = 0; e < kPrintEventCount; ++e) {
      if (state_at(s) == kSlicing || next(state_at(s), event_at(e)) != kSlicing) continue;
      EXPECT_EQ(state_at(s), kOffered);
      EXPECT_EQ(event_at(e), kJobTaken);
    }
  }
}

TEST(PrintState, CoverMayBeOpenedToPourInResin) { EXPECT_EQ(next(kFeedMe, kCoverOpened), kFeedMe); }

TEST(Fault, CodesAreSortedAndUniqueAndTextsAreSentences) {
  const auto faults = fault_words(Language::kEnglish);
  EXPECT_TRUE(std::is_sorted(faults.begin(), faults.end(),
                             [](const FaultWords& a, const FaultWords& b) { return a.number < b.number; }));
  for (std::size_t i = 0; i < faults.size(); ++i) {
    if (i > 0) {
      EXPECT_NE(faults[i].number, faults[i - 1].number);
    }
    EXPECT_FALSE(faults[i].title.empty());
    EXPECT_TRUE(faults[i].meaning.ends_with('.')) << faults[i].meaning;
    EXPECT_TRUE(faults[i].next.ends_with('.')) << faults[i].next;
    EXPECT_EQ(info(static_cast<FaultCode>(faults[i].number)).title, faults[i].title);
  }
}

TEST(Fault, TableHasTheFaultOfEveryError) {
  int errors = 0;
  for (std::uint16_t number = 1; number < 1000; ++number) {
    const auto code = static_cast<ErrorCode>(number);
    if (to_string(code) == "Unknown") continue;
    const auto faults = fault_words(Language::kEnglish);
    EXPECT_TRUE(std::any_of(faults.begin(), faults.end(), [code](const FaultWords& fault) {
      return fault.number == static_cast<std::uint16_t>(fault_of(code));
    })) << to_string(code);
    ++errors;
  }
  EXPECT_GE(errors, 35);
}

TEST(Fault, GivesItsAdviceOnce) {
  const auto dead = explain(FaultCode::kSensorDead, "the lamp's temperature sensor does not answer", "check its plug");
  EXPECT_EQ(dead.what.view(), "PL-601, sensor dead: the lamp's temperature sensor does not answer");
  EXPECT_EQ(dead.advice.view(), "Check the sensor's plug, then resume.") << "the device does not know about resuming";

  const auto large = explain(FaultCode::kDoesNotFit, "the object is 3 mm too high", "Use --scale 0.5 or less");
  EXPECT_EQ(large.what.view(), "PL-105, does not fit the printer: the object is 3 mm too high");
  EXPECT_EQ(large.advice.view(), "Use --scale 0.5 or less.") << "the message knows the numbers";

  const auto reason = explain(FaultCode::kScanUnreadable, "a.ply: No such file or directory");
  EXPECT_EQ(reason.what.view(), "PL-101, scan can't be read: a.ply: No such file or directory");
  EXPECT_EQ(reason.advice.view(), info(FaultCode::kScanUnreadable).next);

  EXPECT_EQ(explain(FaultCode::kPowerLost, "").what.view(), "PL-901, power lost");
}

TEST(Fault, TableInTheReadmeIsThisTable) {
  std::ifstream file(PLUMBLINE_SOURCE_DIR "/firmware/README.md");
  std::stringstream text;
  text << file.rdbuf();
  std::string rows;
  for (const FaultWords& fault : fault_words(Language::kEnglish)) {
    rows += "| PL-" + std::to_string(fault.number) + " | " + std::string(fault.title) + " | " +
            std::string(fault.meaning) + " | " + std::string(fault.next) + " |\n";
  }
  EXPECT_THAT(text.str(), HasSubstr(rows)) << "firmware/README.md lacks these rows, in this order:\n" << rows;
}

}  // namespace
}  // namespace plumbline::firmware
