/// Kept prints where a call fails, the process is killed, or the power goes, at any step: the older prints are whole, and nothing half
/// is listed.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>

#include "firmware/print/job/kept_prints.hpp"
#include "tests/firmware/support/failing_calls.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class KeptPrintsCut : public ::testing::Test {
 protected:
  static constexpr int kOlder = 12;
  static constexpr std::size_t kReportBytes = 3000;
  static constexpr int kDone = 0, kFailed = 3, kNotDurable = 4;

  /// With the most prints that there may be, so that the next one takes the place of the oldest.
  void SetUp() override {
    static_assert(kOlder == KeptPrints::kMost);
    KeptPrints prints = open();
    for (int i = 1; i <= kOlder; ++i) ASSERT_TRUE(keep(prints, report_of(i), png_of(i)));
  }

  KeptPrints open() {
    told_.clear();
    auto prints = KeptPrints::open(folder_ / ".", [this](std::string_view text) { told_.emplace_back(text); });
    EXPECT_TRUE(prints) << prints.error().message();
    return std::move(*prints);
  }
  static std::string report_of(int number) {
    std::string report = "{\"report\": " + std::to_string(number) + "}\n";
    return report + std::string(kReportBytes - report.size(), static_cast<char>('a' + number));
  }
  /// All of one size.
  static std::string png_of(int number) { return "PNG of " + std::to_string(100 + number); }

  /// The report comes in pieces, as a JSON writer's does.
  static Status keep(KeptPrints& prints, std::string_view report, std::string_view png) {
    const auto write_report = [report](TextSink& out) -> Status {
      constexpr std::size_t kPiece = 1000;
      for (std::size_t at = 0; at < report.size(); at += kPiece) PLUMBLINE_TRY(out.write(report.substr(at, kPiece)));
      return {};
    };
    return prints.keep({.layers = 7}, write_report, std::as_bytes(std::span(png)));
  }

  static std::string read(const KeptPrints& prints, std::uint32_t number, KeptPrints::Part part) {
    std::vector<char> room(2 * kReportBytes);
    const auto got = prints.read(number, part, 0, std::as_writable_bytes(std::span(room)));
    return got ? std::string(room.data(), got->bytes) : std::string(got.error().message());
  }
  static std::vector<int> numbers(const KeptPrints& prints) {
    std::vector<int> all;
    for (const KeptPrint& print : prints.list()) all.push_back(static_cast<int>(print.number));
    return all;
  }
  /// Newest first.
  static std::vector<int> from_to(int newest, int oldest) {
    std::vector<int> all;
    for (int number = newest; number >= oldest; --number) all.push_back(number);
    return all;
  }
  static void expect_whole(const KeptPrints& prints) {
    for (const int number : numbers(prints)) {
      EXPECT_EQ(read(prints, static_cast<std::uint32_t>(number), KeptPrints::Part::kReport), report_of(number));
      EXPECT_EQ(read(prints, static_cast<std::uint32_t>(number), KeptPrints::Part::kPreview), png_of(number));
    }
  }
  std::size_t files() const {
    const std::filesystem::directory_iterator folder(folder_ / "prints");
    return static_cast<std::size_t>(std::distance(folder, std::filesystem::directory_iterator()));
  }

  /// Keeps print 13 in a process of its own, whose n-th call ends it.
  /// @returns as of waitpid()
  int keep_and_die(std::uint32_t nth, Failure failure) {
    KeptPrints prints = open();
    const pid_t child = ::fork();
    if (child == 0) {
      const FailingCall call(Calls::kAll, nth, failure);
      const bool kept = keep(prints, report_of(13), png_of(13)).has_value();
      ::_exit(!kept ? kFailed : not_durable() > 0 ? kNotDurable : kDone);
    }
    int status = -1;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return status;
  }

  /// Keeps print 13 with an end at the first, second, ... call. @returns how many calls there are
  std::uint32_t die_at_each_call(Failure failure) {
    bool was_kept = false;
    for (std::uint32_t nth = 1; nth < 100; ++nth) {
      SCOPED_TRACE("call " + std::to_string(nth));
      const int status = keep_and_die(nth, failure);
      const bool died = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
      EXPECT_TRUE(died || WEXITSTATUS(status) == kDone) << WEXITSTATUS(status);
      const KeptPrints prints = open();
      const bool is_kept = numbers(prints).front() == 13;
      EXPECT_EQ(numbers(prints), is_kept ? from_to(13, 2) : from_to(12, 1));
      EXPECT_TRUE(is_kept || !was_kept) << "an earlier call kept it";
      EXPECT_THAT(told_, AnyOf(IsEmpty(), ElementsAre(HasSubstr("was not kept: the power went"))));
      expect_whole(prints);
      EXPECT_EQ(files(), std::size_t{kOlder}) << "nothing half is left";
      if (!died) {
        EXPECT_TRUE(is_kept);
        return nth - 1;
      }
      if (is_kept) {
        was_kept = true;
        std::filesystem::remove_all(folder_ / "prints");
        SetUp();
      }
      if (HasFailure()) break;
    }
    ADD_FAILURE();
    return 0;
  }

  TemporaryFolder folder_;
  std::vector<std::string> told_;
};

TEST_F(KeptPrintsCut, AKillAtAnyStepLeavesTheOlderOnesOrAllWithTheNew) {
  EXPECT_GT(die_at_each_call(Failure::kKilled), 8U);
}

TEST_F(KeptPrintsCut, APowerCutAtAnyStepLeavesTheOlderOnesOrAllWithTheNew) {
  EXPECT_GT(die_at_each_call(Failure::kPowerCut), 8U);
}

TEST_F(KeptPrintsCut, AnyCallThatFailsOnceIsToldAndLeavesTheOlderOnes) {
  std::uint32_t failed = 0;
  constexpr std::array kFailures = {
      std::pair(Calls::kWrites, Failure::kIoError), std::pair(Calls::kWrites, Failure::kCutInHalf),
      std::pair(Calls::kFiles, Failure::kIoError), std::pair(Calls::kRemovals, Failure::kIoError)};
  for (const auto& [calls, failure] : kFailures) {
    for (std::uint32_t nth = 1;; ++nth) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(calls) << ", " << static_cast<int>(failure) << ", call "
                                      << nth);
      std::filesystem::remove_all(folder_ / "prints");
      SetUp();
      KeptPrints prints = open();
      Status kept;
      bool happened = false;
      {
        const FailingCall call(calls, nth, failure);
        kept = keep(prints, report_of(13), png_of(13));
        happened = call.happened();
      }
      if (!kept) {
        EXPECT_TRUE(happened);
        EXPECT_EQ(kept.error().code(), ErrorCode::kCannotWrite);
        EXPECT_THAT(std::string(kept.error().message()), HasSubstr("can't be kept: Input/output error"));
        EXPECT_EQ(numbers(prints), from_to(12, 1));
        ++failed;
      }
      EXPECT_EQ(numbers(open()), numbers(prints)) << "what is told is what there is";
      EXPECT_THAT(told_, IsEmpty());
      expect_whole(prints);
      EXPECT_EQ(files(), std::size_t{kOlder});
      ASSERT_TRUE(keep(prints, report_of(14), png_of(14))) << "the next one is kept";
      if (!happened || HasFailure()) break;
    }
  }
  EXPECT_GT(failed, 8U);
}

TEST_F(KeptPrintsCut, AFullDiskTakesTheRoomOfAsManyOfTheOldestAsItNeeds) {
  for (const Calls calls : {Calls::kWrites, Calls::kFiles}) {
    for (std::uint32_t nth = 1;; ++nth) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(calls) << ", call " << nth);
      std::filesystem::remove_all(folder_ / "prints");
      SetUp();
      KeptPrints prints = open();
      bool happened = false;
      {
        const FailingCall call(calls, nth, Failure::kDiskFull);
        ASSERT_TRUE(keep(prints, report_of(13), png_of(13)));
        happened = call.happened();
      }
      EXPECT_EQ(numbers(prints), from_to(13, 2)) << "all prints have the same size: one is enough";
      EXPECT_EQ(numbers(open()), from_to(13, 2));
      expect_whole(prints);
      if (!happened || HasFailure()) break;
    }
  }
}

TEST_F(KeptPrintsCut, ADiskThatStaysFullCostsNoMoreThanTheRoomOfOnePrint) {
  KeptPrints prints = open();
  {
    const FailingCall call(Calls::kWrites, 2, Failure::kStaysFull);
    const auto kept = keep(prints, report_of(13), png_of(13));
    ASSERT_FALSE(kept);
    EXPECT_THAT(std::string(kept.error().message()), HasSubstr("No space left"));
  }
  EXPECT_EQ(numbers(prints), from_to(12, 2));
  EXPECT_EQ(numbers(open()), from_to(12, 2));
  expect_whole(prints);
  EXPECT_EQ(files(), 11U);
}

TEST_F(KeptPrintsCut, AFullDiskKeepsTheOlderOnesIfAllOfThemAreNotRoomEnough) {
  KeptPrints prints = open();
  {
    const FailingCall call(Calls::kWrites, 1, Failure::kStaysFull);
    ASSERT_FALSE(keep(prints, std::string(std::size_t{kOlder + 2} * kReportBytes, ' '), ""));
  }
  EXPECT_EQ(numbers(prints), from_to(12, 1));
  EXPECT_EQ(numbers(open()), from_to(12, 1));
  expect_whole(prints);
}

TEST_F(KeptPrintsCut, OneThatCantBeReadAtTheStartStaysWhereItIs) {
  for (std::uint32_t nth = 1;; ++nth) {
    SCOPED_TRACE(nth);
    bool happened = false;
    {
      const FailingCall call(Calls::kReads, nth, Failure::kIoError);
      KeptPrints prints = open();
      happened = call.happened();
      EXPECT_EQ(prints.list().size(), happened ? 11U : 12U);
      if (happened) {
        EXPECT_THAT(told_, ElementsAre(HasSubstr("can't be read and is not listed: Input/output error")));
      }
    }
    const KeptPrints prints = open();
    EXPECT_EQ(numbers(prints), from_to(12, 1)) << "and is listed again";
    expect_whole(prints);
    if (!happened || HasFailure()) break;
  }
  // The newest one keeps its number.
  const FailingCall call(Calls::kReads, std::uint32_t{kOlder} * 3, Failure::kIoError);
  KeptPrints prints = open();
  EXPECT_EQ(numbers(prints), from_to(11, 1));
  ASSERT_TRUE(keep(prints, report_of(13), png_of(13)));
  EXPECT_EQ(numbers(prints).front(), 13);
}

}  // namespace
}  // namespace plumbline::firmware
