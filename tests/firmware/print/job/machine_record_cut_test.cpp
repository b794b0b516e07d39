/// The machine's record where the process is killed, the power goes or a call fails at any step: it has the state before or after.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "firmware/print/job/machine_record.hpp"
#include "tests/firmware/support/failing_calls.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

class MachineRecordCut : public ::testing::Test {
 protected:
  static constexpr double kTank = 100;
  static constexpr int kWritten = 0, kRefused = 3, kLeftUndurable = 4;

  void SetUp() override {
    MachineRecord record = open();
    ASSERT_TRUE(record.fill(30));
    ASSERT_TRUE(record.add_fault(FaultCode::kStickGone, "before"));
  }
  MachineRecord open() const {
    auto record = MachineRecord::open(folder_ / ".", kTank);
    EXPECT_TRUE(record) << record.error().message();
    return std::move(*record);
  }
  /// Several changes in one write.
  static Status change(MachineRecord& record) {
    record.felt(TemperatureSite::kResin, Celsius(25));
    return record.fill(60);
  }
  static void expect_before_or_after(const MachineRecord& record, bool* is_after = nullptr) {
    const bool after = record.resin_ml() == 60;
    EXPECT_TRUE(after || record.resin_ml() == 30) << record.resin_ml().value_or(-1);
    EXPECT_EQ(record.hottest(TemperatureSite::kResin).has_value(), after) << "all of it or nothing";
    EXPECT_EQ(record.fault_count(), 1U);
    EXPECT_FALSE(record.was_damaged());
    if (is_after != nullptr) *is_after = after;
  }
  /// @returns as of waitpid()
  template <class Work>
  static int in_child(std::uint32_t nth, Failure failure, Work work) {
    const pid_t child = ::fork();
    if (child == 0) {
      const FailingCall call(Calls::kAll, nth, failure);
      const bool done = work();
      ::_exit(!done ? kRefused : not_durable() > 0 ? kLeftUndurable : kWritten);
    }
    int status = -1;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return status;
  }
  /// @returns how many calls there are
  std::uint32_t die_at_each_call(Failure failure) {
    bool was_after = false;
    for (std::uint32_t nth = 1; nth < 100; ++nth) {
      SCOPED_TRACE("call " + std::to_string(nth));
      MachineRecord record = open();
      const int status = in_child(nth, failure, [&] { return change(record).has_value(); });
      const bool died = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
      EXPECT_TRUE(died || WEXITSTATUS(status) == kWritten) << WEXITSTATUS(status);
      bool is_after = false;
      expect_before_or_after(open(), &is_after);
      EXPECT_TRUE(is_after || !was_after) << "an earlier call wrote it";
      was_after = is_after;
      if (!died) {
        EXPECT_TRUE(is_after);
        return nth - 1;
      }
      if (is_after) {
        std::filesystem::remove(folder_ / "machine");
        SetUp();
      }
      if (HasFailure()) break;
    }
    ADD_FAILURE();
    return 0;
  }

  TemporaryFolder folder_;
};

TEST_F(MachineRecordCut, AKillAtAnyStepLeavesTheStateBeforeOrAfter) {
  EXPECT_GE(die_at_each_call(Failure::kKilled), 6U);
}

TEST_F(MachineRecordCut, APowerCutAtAnyStepLeavesTheStateBeforeOrAfter) {
  // A write to one copy, its sync and its reading, then the same of the other. What is not durable turns into zeros in the test, so
  // the record's own copies are judged by kKilled, and here only the first write of a new printer's.
  std::filesystem::remove(folder_ / "machine");
  for (std::uint32_t nth = 1; nth < 100; ++nth) {
    SCOPED_TRACE("call " + std::to_string(nth));
    const int status =
        in_child(nth, Failure::kPowerCut, [&] { return MachineRecord::open(folder_ / ".", kTank).has_value(); });
    const MachineRecord record = open();
    EXPECT_FALSE(record.plate_is_empty());
    EXPECT_FALSE(record.resin_ml());
    std::filesystem::remove(folder_ / "machine");
    if (!WIFSIGNALED(status)) {
      EXPECT_EQ(WEXITSTATUS(status), kWritten);
      EXPECT_GT(nth, 6U);
      return;
    }
  }
  ADD_FAILURE();
}

TEST_F(MachineRecordCut, APersonsWordCountsUntilTheRecordHasIt) {
  for (std::uint32_t nth = 1; nth < 100; ++nth) {
    SCOPED_TRACE("call " + std::to_string(nth));
    write_text(folder_ / "plate-is-empty", "");
    const int status =
        in_child(nth, Failure::kKilled, [&] { return MachineRecord::open(folder_ / ".", kTank).has_value(); });
    MachineRecord record = open();
    EXPECT_TRUE(record.plate_is_empty());
    EXPECT_FALSE(std::filesystem::exists(folder_ / "plate-is-empty"));
    ASSERT_TRUE(record.take_plate());
    EXPECT_FALSE(open().plate_is_empty());
    if (!WIFSIGNALED(status)) return;
  }
  ADD_FAILURE();
}

TEST_F(MachineRecordCut, AnyCallThatFailsIsToldAndThePlateCountsAsInUse) {
  std::uint32_t failed = 0;
  for (const Calls calls : {Calls::kWrites, Calls::kFiles, Calls::kReads}) {
    for (std::uint32_t nth = 1;; ++nth) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(calls) << ", call " << nth);
      MachineRecord record = open();
      ASSERT_TRUE(record.take_plate());
      Status kept;
      bool happened = false;
      {
        const FailingCall call(calls, nth, Failure::kIoError);
        kept = record.confirm_empty();
        happened = call.happened();
      }
      EXPECT_EQ(record.plate_is_empty(), kept.has_value());
      if (!kept) ++failed;
      if (!happened || HasFailure()) break;
    }
  }
  EXPECT_EQ(failed, 6U) << "a write, a sync and a read of each copy";
}

}  // namespace
}  // namespace plumbline::firmware
