/// Each system call on a file fails once, the n-th for every n until the job succeeds: a clear error, nothing half-written, everything
/// released.

#include "tests/firmware/support/failing_calls.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <map>
#include <span>

#include "firmware/daemon/upload/upload_store.hpp"
#include "firmware/io/file_source.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/slice/slice_job.hpp"
#include "hal/sim/sim_machine.hpp"
#include "tests/firmware/support/job_fixture.hpp"
#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr Failure kWriteFailures[] = {Failure::kIoError, Failure::kDiskFull, Failure::kShort};

alignas(Arena::kAlignment) std::byte block[std::size_t{24} << 20U];

std::size_t open_files() {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

/// All files below a folder, by path, with their bytes.
std::map<std::string, std::string> files_in(const std::string& folder) {
  std::map<std::string, std::string> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.emplace(fs::relative(entry.path(), folder), read_text(entry.path()));
  }
  return files;
}

void expect_reason(const Error& error, Failure failure) {
  EXPECT_THAT(error.message(), HasSubstr(failure == Failure::kIoError ? "Input/output error" : "No space left"));
}

/// Calls `attempt(failing)` with the first, second, ... call failing, until that call no longer comes.
/// @returns how many calls have failed
template <class Attempt>
std::uint32_t for_each_call(Calls calls, Failure failure, Attempt attempt) {
  for (std::uint32_t nth = 1;; ++nth) {
    SCOPED_TRACE("call " + std::to_string(nth));
    if (!attempt(nth, calls, failure)) return nth - 1;
    if (::testing::Test::HasFailure() || nth > 5000) {
      ADD_FAILURE();
      return nth;
    }
  }
}

class SlicingFailure : public ::testing::Test {
 protected:
  SlicingFailure() {
    write_sphere_scan(folder_ / "sphere.ply", 400, 2);
    settings_ = sphere_job(folder_);
    settings_.slice.placement.layer_height_mm = 1;
    settings_.slice.threads = 1;
  }

  Status slice() {
    Arena arena(block);
    auto job = SliceJob::prepare(settings_, arena);
    PLUMBLINE_TRY(job);
    JobProgress progress(nullptr);
    auto done = job->run(progress);
    EXPECT_EQ(arena.used(), 0U);
    return done;
  }
  std::string out() const { return folder_ / "out"; }

  /// @returns whether the call came
  bool fails_cleanly(std::uint32_t nth, Calls calls, Failure failure) {
    const std::size_t files = open_files();
    Status done;
    bool happened = false;
    {
      const FailingCall call(calls, nth, failure);
      done = slice();
      happened = call.happened();
    }
    EXPECT_EQ(open_files(), files);
    // Some calls may fail without harm: the lock's close, for one.
    if (!done) {
      EXPECT_TRUE(happened);
      EXPECT_THAT(done.error().code(), AnyOf(ErrorCode::kCannotWrite, ErrorCode::kCannotOpen, ErrorCode::kCannotRead));
      expect_reason(done.error(), failure);
      EXPECT_FALSE(fs::exists(out())) << "half a job";
      ++failed_;
    } else {
      EXPECT_EQ(files_in(out()).count("manifest.json"), 1U);
      EXPECT_EQ(layers(), whole_);
      fs::remove_all(out());
    }
    return happened;
  }
  std::map<std::string, std::string> layers() const { return files_in(out() + "/layers"); }

  TemporaryFolder folder_;
  SliceJobSettings settings_;
  std::map<std::string, std::string> whole_;
  std::uint32_t failed_ = 0;
};

class WriteFailure : public SlicingFailure, public ::testing::WithParamInterface<Failure> {};

TEST_P(WriteFailure, OfLayersPicturesAndManifestLeavesNothingBehind) {
  settings_.preview = GetParam() == Failure::kIoError;  // its many writes take long
  ASSERT_TRUE(slice());
  whole_ = layers();
  ASSERT_EQ(whole_.size(), 4U);
  fs::remove_all(out());
  const auto calls = for_each_call(Calls::kWrites, GetParam(), [this](auto... how) { return fails_cleanly(how...); });
  EXPECT_EQ(failed_, calls) << "each is noticed";
  EXPECT_GT(calls, whole_.size());
}

INSTANTIATE_TEST_SUITE_P(Slicing, WriteFailure, ::testing::ValuesIn(kWriteFailures), [](const auto& failure) {
  return std::string(failure.param == Failure::kIoError    ? "IoError"
                     : failure.param == Failure::kDiskFull ? "DiskFull"
                                                           : "Short");
});

TEST(WholeFile, IsWrittenWholeOrNotAtAllWhicheverCallFails) {
  const TemporaryFolder folder;
  const std::string path = folder / "report.json", text(5000, 'x');
  std::uint32_t failed = 0;
  for (const Calls calls : {Calls::kWrites, Calls::kFiles}) {
    for (const Failure failure : {Failure::kIoError, Failure::kDiskFull, Failure::kShort, Failure::kStaysFull}) {
      failed += for_each_call(calls, failure, [&](std::uint32_t nth, Calls these, Failure with) {
        write_text(path, "the report before");
        const FailingCall call(these, nth, with);
        const auto written = write_whole_file(path.c_str(), [&](TextSink& out) -> Status {
          for (std::size_t at = 0; at < text.size(); at += 1000) PLUMBLINE_TRY(out.write(text.substr(at, 1000)));
          return {};
        });
        EXPECT_EQ(files_in(folder / "."), written ? (std::map<std::string, std::string>{{"report.json", text}})
                                                  : (std::map<std::string, std::string>{}));
        return call.happened();
      });
    }
  }
  EXPECT_GT(failed, 20U);
}

TEST_F(SlicingFailure, ToCreateCloseOrRenameAFileLeavesNothingBehind) {
  settings_.preview = false;
  ASSERT_TRUE(slice());
  whole_ = layers();
  fs::remove_all(out());
  const auto attempt = [this](auto... how) { return fails_cleanly(how...); };
  EXPECT_GT(for_each_call(Calls::kFiles, Failure::kIoError, attempt), 2 * whole_.size());
  EXPECT_GT(failed_, 2 * whole_.size());
  // A short write alone is no failure.
  failed_ = 0;
  for_each_call(Calls::kWrites, Failure::kCutInHalf, attempt);
  EXPECT_EQ(failed_, 0U);
}

TEST_F(SlicingFailure, OfAnyReadOfAScanIsAnErrorOfThatScan) {
  settings_.preview = false;
  const auto cloud = sphere_scan(3000, 2);
  std::string text;
  for (const auto& p : cloud)
    text += std::to_string(p.x) + ' ' + std::to_string(p.y) + ' ' + std::to_string(p.z) + '\n';
  write_text(folder_ / "sphere.xyz", text);
  for (const char* name : {"sphere.ply", "sphere.xyz"}) {
    SCOPED_TRACE(name);
    settings_.scan_paths = {folder_ / name};
    ASSERT_TRUE(slice());
    whole_ = layers();
    fs::remove_all(out());
    failed_ = 0;
    const auto attempt = [this](auto... how) { return fails_cleanly(how...); };
    const auto calls = for_each_call(Calls::kReads, Failure::kIoError, attempt);
    EXPECT_GT(calls, 1U);
    EXPECT_EQ(failed_, calls);
    failed_ = 0;
    for_each_call(Calls::kReads, Failure::kCutInHalf, attempt);
    EXPECT_EQ(failed_, 0U) << "a short read is no failure";
  }
}

class PrintingFailure : public ::testing::Test {
 protected:
  PrintingFailure() {
    write_sphere_scan(folder_ / "ball.ply", 400, 0.45);
    slicing_.placement.layer_height_mm = 0.1F;
    slicing_.threads = 1;
  }
  std::string state() const { return folder_ / "state"; }

  /// Slices, stores, prints on a new simulated printer.
  /// @returns the error before the print, or nothing
  Status print(std::uint32_t nth, Calls calls, Failure failure) {
    auto store = JobStore::open(state());
    PLUMBLINE_TRY(store);
    auto scan = FileSource::open(folder_ / "ball.ply");
    PLUMBLINE_TRY(scan);
    Plant plant(session_plant());
    SimMachine run(plant);
    Machine machine = run.machine();
    Silent observer;
    Arena arena(block);
    {
      PrintSession session(board_, machine_file_, arena, &*store);
      const FailingCall call(calls, nth, failure);
      const auto ready = slice_into(session, *scan, slicing_, std::nullopt, rig_profile(), machine_file_, arena);
      happened_ = call.happened();
      if (!ready) {
        EXPECT_FALSE(store->has_job());
        EXPECT_TRUE(files_in(state()).empty()) << files_in(state()).begin()->first;
        return ready;
      }
      report_ = session.print(machine, observer);
      happened_ = call.happened();
    }
    EXPECT_EQ(arena.used(), 0U);
    EXPECT_FALSE(plant.light());
    // All are lit but the one that the failure has ended.
    cured_ = static_cast<std::uint32_t>(plant.part().layers().size());
    EXPECT_EQ(report_.state == PrintState::kFinished, !store->has_job());
    return {};
  }
  /// What the store has of a print that has failed. @returns its next layer
  Expected<std::uint32_t> stored() {
    auto store = JobStore::open(state());
    PLUMBLINE_TRY(store);
    Arena arena(block);
    auto job = store->load(arena);
    PLUMBLINE_TRY(job);
    const auto journal = Journal::open(job->journal);
    PLUMBLINE_TRY(journal);
    EXPECT_EQ(journal->job_hash(), job->job.hash);
    return journal->last().next_layer;
  }
  /// @returns whether the call came
  bool fails_cleanly(std::uint32_t nth, Calls calls, Failure failure) {
    const std::size_t files = open_files();
    const auto done = print(nth, calls, failure);
    EXPECT_EQ(open_files(), files);
    if (!done) {
      EXPECT_THAT(done.error().code(), AnyOf(ErrorCode::kCannotWrite, ErrorCode::kCannotRead));
      expect_reason(done.error(), failure);
      ++failed_;
    } else if (report_.state == PrintState::kFault) {
      EXPECT_EQ(report_.fault, FaultCode::kCannotWrite) << report_.fault_message.c_str();
      const auto next = stored();
      EXPECT_TRUE(next) << next.error().message();
      EXPECT_TRUE(next == cured_ || next == cured_ - 1) << *next << " of " << cured_;
      ++failed_;
    } else {
      EXPECT_EQ(report_.state, PrintState::kFinished) << report_.fault_message.c_str();
    }
    return happened_;
  }

  TemporaryFolder folder_;
  BoardFile board_ = session_board();
  MachineFile machine_file_ = rig_machine();
  SliceSettings slicing_ = slicing_for(board_);
  PrintReport report_;
  std::uint32_t cured_ = 0;
  bool happened_ = false;
  std::uint32_t failed_ = 0;
};

TEST_F(PrintingFailure, OfAnyWriteOfStoreAndJournalEndsThePrintWithWhatItTakesToResume) {
  const auto undisturbed = print(0, Calls::kWrites, Failure::kIoError);
  ASSERT_TRUE(undisturbed) << undisturbed.error().message();
  ASSERT_EQ(report_.state, PrintState::kFinished) << report_.fault_message.c_str();
  const auto attempt = [this](auto... how) { return fails_cleanly(how...); };
  for (const Failure failure : kWriteFailures) {
    SCOPED_TRACE(static_cast<int>(failure));
    failed_ = 0;
    const auto calls = for_each_call(Calls::kWrites, failure, attempt);
    EXPECT_EQ(failed_, calls) << "each is noticed";
    EXPECT_GT(calls, 2 * report_.layers);
  }
}

TEST_F(PrintingFailure, OfAnyOtherCallOfStoreAndJournalDoesTheSame) {
  const auto attempt = [this](auto... how) { return fails_cleanly(how...); };
  EXPECT_GT(for_each_call(Calls::kFiles, Failure::kIoError, attempt), 2 * report_.layers);
  EXPECT_GT(failed_, 2 * report_.layers) << "fdatasync";
  failed_ = 0;
  for_each_call(Calls::kWrites, Failure::kCutInHalf, attempt);
  EXPECT_EQ(failed_, 0U);
}

/// Counts what is not durable whenever a print says how far it is.
class DurabilityObserver final : public PrintObserver {
 public:
  bool update(const PrintStatus& status) override {
    if (status.state == PrintState::kPrinting) {
      ++looks;
      most = std::max(most, not_durable());
    }
    return true;
  }
  void checked(Check /*check*/, const CheckResult& /*result*/) override {}
  std::size_t most = 0, looks = 0;
};

TEST_F(PrintingFailure, OfThePowerLosesNothingOfWhatWasStored) {
  auto store = JobStore::open(state());
  ASSERT_TRUE(store);
  auto scan = FileSource::open(folder_ / "ball.ply");
  ASSERT_TRUE(scan);
  Plant plant(session_plant());
  SimMachine run(plant);
  Machine machine = run.machine();
  Arena arena(block);
  PrintSession session(board_, machine_file_, arena, &*store);
  const FailingCall counted(Calls::kAll, 0, Failure::kPowerCut);
  ASSERT_TRUE(slice_into(session, *scan, slicing_, std::nullopt, rig_profile(), machine_file_, arena));
  EXPECT_EQ(not_durable() + names_not_durable(), 0U) << "job, journal and their names";
  DurabilityObserver observer;
  const auto& report = session.print(machine, observer);
  EXPECT_EQ(report.state, PrintState::kFinished);
  EXPECT_GE(observer.looks, report.layers);
  EXPECT_EQ(observer.most, 0U) << "a layer's record is durable before anything else happens";
}

TEST(MachineRecordPowerCut, LeavesWhatWasSaidOfPlateAndTank) {
  const TemporaryFolder folder;
  auto record = MachineRecord::open(folder / ".", 100);
  ASSERT_TRUE(record);
  const FailingCall counted(Calls::kAll, 0, Failure::kPowerCut);
  ASSERT_TRUE(record->confirm_empty());
  EXPECT_EQ(not_durable() + names_not_durable(), 0U);
  ASSERT_TRUE(record->fill(80));
  EXPECT_EQ(not_durable() + names_not_durable(), 0U);
  ASSERT_TRUE(record->begin_print(77, {.pixel_ml = 1e-5}));
  EXPECT_EQ(not_durable() + names_not_durable(), 0U) << "else the next start takes a plate with a part for empty";
}

/// Keeps a scan in the store of uploads, in place of another one.
class UploadFailure : public ::testing::Test {
 protected:
  static constexpr std::string_view kOld = "the scan before";

  static Status upload(UploadStore& store, std::string_view name, std::string_view text) {
    PLUMBLINE_TRY(store.begin(name, text.size()));
    for (std::string_view rest = text; !rest.empty(); rest.remove_prefix(std::min(rest.size(), kPart))) {
      PLUMBLINE_TRY(store.write(std::as_bytes(std::span(rest.substr(0, kPart)))));
    }
    return store.keep();
  }
  bool fails_cleanly(std::uint32_t nth, Calls calls, Failure failure) {
    const std::size_t files = open_files();
    Status done;
    bool happened = false;
    {
      auto store = UploadStore::open(folder_ / ".", std::uint64_t{1} << 30U);
      EXPECT_TRUE(store);
      EXPECT_TRUE(upload(*store, "old.ply", kOld));
      const FailingCall call(calls, nth, failure);
      done = upload(*store, "new.ply", new_);
      happened = call.happened();
      EXPECT_EQ(store->kept(), files_in(uploads()).begin()->first);
    }
    EXPECT_EQ(open_files(), files);
    const auto kept = files_in(uploads());
    EXPECT_EQ(kept.size(), 1U) << "half a scan";
    const bool is_new = kept.count("new.ply") == 1;
    EXPECT_EQ(kept.begin()->second, is_new ? new_ : kOld);
    EXPECT_TRUE(is_new || !done);
    if (!done) {
      EXPECT_TRUE(happened);
      EXPECT_EQ(done.error().code(), ErrorCode::kCannotWrite);
      EXPECT_THAT(done.error().message(), HasSubstr(failure == Failure::kIoError ? "Input/output error" : "is full"));
      ++failed_;
    }
    return happened;
  }
  std::string uploads() const { return folder_ / "uploads"; }

  static constexpr std::size_t kPart = std::size_t{1} << 20U;
  TemporaryFolder folder_;
  std::string new_ = std::string(UploadStore::kDurableBytes + kPart + 2, 'x');
  std::uint32_t failed_ = 0;
};

TEST_F(UploadFailure, OfAnyCallLeavesOneWholeScan) {
  const auto attempt = [this](auto... how) { return fails_cleanly(how...); };
  for (const Failure failure : kWriteFailures) {
    SCOPED_TRACE(static_cast<int>(failure));
    failed_ = 0;
    EXPECT_EQ(for_each_call(Calls::kWrites, failure, attempt), failed_) << "each is noticed";
    EXPECT_GT(failed_, 5U);
  }
  failed_ = 0;
  for_each_call(Calls::kFiles, Failure::kIoError, attempt);
  EXPECT_GE(failed_, 4U) << "open, fdatasync, fsync, rename";
  failed_ = 0;
  for_each_call(Calls::kWrites, Failure::kCutInHalf, attempt);
  EXPECT_EQ(failed_, 0U) << "a short write alone is no failure";
}

TEST_F(UploadFailure, AKillOrAPowerCutAtAnyCallLeavesOneWholeScanOrNoneThatWasToGo) {
  for (const Failure failure : {Failure::kKilled, Failure::kPowerCut}) {
    for (const bool removes : {false, true}) {
      SCOPED_TRACE(removes ? "removes" : "keeps");
      const auto calls = for_each_call(Calls::kAll, failure, [&](std::uint32_t nth, Calls all, Failure how) {
        auto store = UploadStore::open(folder_ / ".", std::uint64_t{1} << 30U);
        EXPECT_TRUE(store);
        EXPECT_TRUE(upload(*store, "old.ply", kOld));
        const pid_t child = ::fork();
        if (child == 0) {
          const FailingCall call(all, nth, how);
          const Status done = removes ? store->remove() : upload(*store, "new.ply", new_);
          ::_exit(done && not_durable() == 0 ? 0 : 1);
        }
        int status = -1;
        EXPECT_EQ(::waitpid(child, &status, 0), child);
        const bool died = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
        EXPECT_TRUE(died || status == 0) << status;
        const auto again = UploadStore::open(folder_ / ".", std::uint64_t{1} << 30U);
        EXPECT_TRUE(again);
        const auto kept = files_in(uploads());
        EXPECT_EQ(kept.size(), again->kept().empty() ? 0U : 1U);
        for (const auto& [name, text] : kept) EXPECT_EQ(text, name == "new.ply" ? new_ : kOld) << name;
        EXPECT_TRUE(removes || !kept.empty());
        if (!died) {
          EXPECT_EQ(kept.count("new.ply"), removes ? 0U : 1U);
          EXPECT_EQ(kept.count("old.ply"), 0U);
        }
        return died;
      });
      EXPECT_GE(calls, removes ? 2U : 10U);
    }
  }
}

TEST_F(UploadFailure, OfAnyCallRemovesAScanOrSaysThatItIsThere) {
  for (const Calls calls : {Calls::kRemovals, Calls::kFiles}) {
    failed_ = 0;
    for_each_call(calls, Failure::kIoError, [this](std::uint32_t nth, Calls which, Failure failure) {
      auto store = UploadStore::open(folder_ / ".", std::uint64_t{1} << 30U);
      EXPECT_TRUE(store);
      EXPECT_TRUE(upload(*store, "old.ply", kOld));
      const std::size_t files = open_files();
      const FailingCall call(which, nth, failure);
      const auto done = store->remove();
      EXPECT_EQ(open_files(), files);
      EXPECT_EQ(files_in(uploads()).count("old.ply"), store->kept().empty() ? 0U : 1U);
      if (!done) {
        EXPECT_EQ(done.error().code(), ErrorCode::kCannotWrite);
        EXPECT_THAT(done.error().message(), HasSubstr("Input/output error"));
        ++failed_;
      }
      EXPECT_EQ(done.has_value(), !call.happened()) << "each is noticed";
      return call.happened();
    });
    EXPECT_EQ(failed_, 1U) << "unlink, fsync";
  }
}

}  // namespace
}  // namespace plumbline::firmware
