#include "firmware/print/job/machine_record.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace machine_record_test {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr double kTankMl = 180;
constexpr std::uint64_t kJobHash = 77;

class MachineRecordTest : public ::testing::Test {
 protected:
  std::string state() const { return folder_ / "."; }
  std::string file() const { return folder_ / "machine"; }
  MachineRecord open() const {
    auto record = MachineRecord::open(state(), kTankMl);
    EXPECT_TRUE(record) << record.error().message();
    return std::move(*record);
  }
  /// Spoils a byte of each copy.
  void spoil(std::initializer_list<std::size_t> places) const {
    std::string bytes = read_text(file());
    for (const std::size_t place : places) bytes.at(place) = static_cast<char>(bytes.at(place) ^ 1);
    write_text(file(), bytes);
  }

  TemporaryFolder folder_;
};

TEST_F(MachineRecordTest, KnowsNothingOfANewPrinter) {
  const MachineRecord record = open();
  EXPECT_FALSE(record.plate_is_empty()) << "nobody has looked at it";
  EXPECT_FALSE(record.resin_ml());
  EXPECT_FALSE(record.hottest(TemperatureSite::kLamp));
  EXPECT_EQ(record.fault_count(), 0U);
  EXPECT_FALSE(record.was_damaged());
}

TEST_F(MachineRecordTest, OutlivesTheProgramThatWroteIt) {
  {
    MachineRecord record = open();
    ASSERT_TRUE(record.confirm_empty());
    ASSERT_TRUE(record.fill(50));
    ASSERT_TRUE(record.begin_print(kJobHash, {.pixel_ml = 1e-5, .first_layer_more_ml = 0.5}));
    record.note({.pixels = 100'000, .layers = 10, .lamp = 25s});
    record.note({.pixels = 200'000, .layers = 20, .lamp = 50s});
    record.felt(TemperatureSite::kLamp, Celsius(51.5));
    record.felt(TemperatureSite::kLamp, Celsius(48));
    ASSERT_TRUE(record.keep());
    ASSERT_TRUE(record.add_fault(FaultCode::kLampDead, "no light in layer 3"));
  }
  MachineRecord record = open();
  EXPECT_FALSE(record.plate_is_empty());
  EXPECT_NEAR(record.resin_ml().value_or(0), 50 - 2 - 0.5, 1e-12);
  EXPECT_EQ(record.filled_ml(), 50);
  EXPECT_EQ(record.film_layers(), 20U);
  EXPECT_EQ(record.lamp_lit(), 50s);
  EXPECT_EQ(record.hottest(TemperatureSite::kLamp), Celsius(51.5));
  ASSERT_EQ(record.fault_count(), 1U);
  EXPECT_EQ(record.fault(0).code, FaultCode::kLampDead);
  EXPECT_EQ(record.fault(0).finding, "no light in layer 3");
  ASSERT_TRUE(record.fault_seen());
  EXPECT_EQ(open().fault_count(), 0U);
}

TEST_F(MachineRecordTest, CountsAFillOnceAndWhatAPrintUsesAfterwards) {
  MachineRecord record = open();
  ASSERT_TRUE(record.begin_print(kJobHash, {.pixel_ml = 1e-5}));
  record.note({.pixels = 300'000});
  ASSERT_TRUE(record.fill(10));
  EXPECT_EQ(record.resin_ml(), 10);
  record.note({.pixels = 400'000});
  EXPECT_NEAR(*record.resin_ml(), 9, 1e-12);
  ASSERT_TRUE(record.begin_print(kJobHash + 1, {.pixel_ml = 2e-5}));
  record.note({.pixels = 100'000});
  EXPECT_NEAR(*record.resin_ml(), 7, 1e-12);
  ASSERT_TRUE(record.fill(1e6));
  EXPECT_EQ(record.resin_ml(), kTankMl) << "no more than a full tank";
}

TEST_F(MachineRecordTest, KeepsTheNewestFaultsIfNobodyComes) {
  MachineRecord record = open();
  for (const FaultCode code : {FaultCode::kStickGone, FaultCode::kLampDead, FaultCode::kSensorDead,
                               FaultCode::kCoverOpen, FaultCode::kStepsLost}) {
    ASSERT_TRUE(record.add_fault(code, std::string(300, 'x')));
  }
  const MachineRecord again = open();
  ASSERT_EQ(again.fault_count(), MachineRecord::kMostFaults);
  EXPECT_EQ(again.fault(0).code, FaultCode::kLampDead);
  EXPECT_EQ(again.fault(3).code, FaultCode::kStepsLost);
  EXPECT_EQ(again.fault(3).finding, std::string(151, 'x'));
}

TEST_F(MachineRecordTest, TakesAPersonsWordFromAFileOnce) {
  write_text(folder_ / "plate-is-empty", "");
  write_text(folder_ / "tank-is-full", "");
  MachineRecord record = open();
  EXPECT_TRUE(record.plate_is_empty());
  EXPECT_EQ(record.resin_ml(), kTankMl);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "plate-is-empty"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "tank-is-full"));
  ASSERT_TRUE(record.take_plate());
  EXPECT_FALSE(open().plate_is_empty());
}

TEST_F(MachineRecordTest, ReadsTheOtherCopyWhereOneIsDamagedAndMendsIt) {
  for (const std::size_t copy : {0U, 4096U}) {
    ASSERT_TRUE(open().fill(42));
    spoil({copy + 30});
    EXPECT_EQ(open().resin_ml(), 42);
    EXPECT_FALSE(open().was_damaged());
    spoil({4096 - copy + 30});
    EXPECT_EQ(open().resin_ml(), 42) << "the damaged copy was written again";
  }
}

TEST_F(MachineRecordTest, WithBothCopiesDamagedThePlateIsInUseAndTheResinUnknown) {
  {
    MachineRecord record = open();
    ASSERT_TRUE(record.confirm_empty());
    ASSERT_TRUE(record.fill(42));
  }
  spoil({30, 4096 + 31});
  const MachineRecord record = open();
  EXPECT_TRUE(record.was_damaged());
  EXPECT_FALSE(record.plate_is_empty());
  EXPECT_FALSE(record.resin_ml());
  std::filesystem::resize_file(file(), 100);
  EXPECT_TRUE(open().was_damaged()) << "cut off";
}

TEST_F(MachineRecordTest, RefusesAnotherVersionsRecordInWords) {
  static_cast<void>(open());
  std::string bytes = read_text(file());
  for (const std::size_t copy : {0U, 4096U}) bytes.at(copy + 3) = '2';
  write_text(file(), bytes);
  const auto record = MachineRecord::open(state(), kTankMl);
  ASSERT_FALSE(record);
  EXPECT_EQ(record.error().code(), ErrorCode::kUnsupported);
  EXPECT_THAT(record.error().message(), HasSubstr("another version"));
  EXPECT_EQ(read_text(file()), bytes) << "it stays as it is";
}

TEST_F(MachineRecordTest, ThatCantBeKeptIsAnError) {
  std::filesystem::create_directory(file());
  const auto record = MachineRecord::open(state(), kTankMl);
  ASSERT_FALSE(record);
  EXPECT_EQ(record.error().code(), ErrorCode::kCannotOpen);
  EXPECT_THAT(record.error().message(), HasSubstr("machine"));
}

/// A store with a print of which `entry` is the journal's last.
JobStore interrupted(const std::string& folder, const JournalEntry& entry, std::uint64_t& job_hash) {
  static constexpr std::array<std::uint32_t, 4> kFirst = {0, 2, 2, 2};
  static constexpr std::array<std::uint32_t, 2> kPacked = {1, 3};
  auto store = JobStore::open(folder).value();
  auto file = store.begin(
      JobFacts(), {{.grid = {.columns = 4, .rows = 2, .layers = 3}, .first = kFirst, .packed = kPacked}, {}, {}});
  EXPECT_TRUE(file) << file.error().message();
  auto journal = Journal::open(*file).value();
  job_hash = journal.job_hash();
  if (entry != JournalEntry()) {
    EXPECT_TRUE(journal.append(entry));
  }
  return store;
}

JournalEntry used(std::uint32_t next_layer, std::uint64_t cured, std::uint32_t at_hand = 0, nanoseconds lamp = {}) {
  JournalEntry entry;
  entry.next_layer = next_layer;
  entry.cured_pixels = cured;
  entry.at_hand_pixels = at_hand;
  entry.lamp = lamp;
  return entry;
}

TEST_F(MachineRecordTest, AddsWhatAnInterruptedPrintHasUsedAndTheLayerThatMayHaveBeenLit) {
  std::uint64_t job_hash = 0;
  const JobStore store = interrupted(state(), used(1, 200'000, 50'000, 5s), job_hash);
  {
    MachineRecord record = open();
    ASSERT_TRUE(record.fill(10));
    ASSERT_TRUE(record.begin_print(job_hash, {.pixel_ml = 1e-5}));
  }
  for (int restart = 0; restart < 3; ++restart) {
    const auto record = open_machine_record(state(), store, kTankMl, false);
    ASSERT_TRUE(record) << record.error().message();
    EXPECT_NEAR(record->resin_ml().value_or(0), 7.5, 1e-9) << "once, whatever the number of restarts";
    EXPECT_EQ(record->film_layers(), 1U);
    EXPECT_EQ(record->lamp_lit(), 5s);
  }
}

TEST_F(MachineRecordTest, DoesNotKnowTheResinAfterAPrintThatItDoesNotKnow) {
  std::uint64_t job_hash = 0;
  ASSERT_TRUE(open().fill(10));
  {
    const JobStore store = interrupted(state(), {}, job_hash);
    EXPECT_EQ(open_machine_record(state(), store, kTankMl, false)->resin_ml(), 10) << "nothing was lit";
  }
  const JobStore store = interrupted(state(), used(1, 2), job_hash);
  EXPECT_FALSE(open_machine_record(state(), store, kTankMl, false)->resin_ml());
  EXPECT_FALSE(open_machine_record(state(), store, kTankMl, true)->resin_ml()) << "also of a simulated printer";
}

TEST_F(MachineRecordTest, OfANewSimulatedPrinterHasAFullTank) {
  auto store = JobStore::open(state()).value();
  EXPECT_FALSE(open_machine_record(state(), store, kTankMl, false)->resin_ml());
  EXPECT_EQ(open_machine_record(state(), store, kTankMl, true)->resin_ml(), kTankMl);
}

TEST_F(MachineRecordTest, WithoutAFolderCountsOnAFullTank) {
  MachineRecord record(kTankMl);
  EXPECT_EQ(record.resin_ml(), kTankMl);
  ASSERT_TRUE(record.begin_print(0, {.pixel_ml = 1e-5}));
  record.note({.pixels = 100'000});
  EXPECT_NEAR(*record.resin_ml(), kTankMl - 1, 1e-9);
  EXPECT_FALSE(std::filesystem::exists(file()));
}

}  // namespace machine_record_test
}  // namespace plumbline::firmware
