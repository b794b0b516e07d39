/// Cuts the power at any instant, even inside the journal's writes. The print must resume at the right layer and make the same
/// part, except for the mark that the report warns of.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/hil/rig.hpp"

namespace plumbline::firmware {
namespace {

using enum PrintState;

struct Reference {
  std::vector<std::vector<std::uint64_t>> part;
  std::vector<std::uint64_t> hashes;
  nanoseconds duration{};
};

const Reference& reference() {
  static const Reference whole = [] {
    Rig rig;
    const auto& report = rig.run();
    Reference result;
    result.part = rig.part();
    for (const auto& line : report.exposures) result.hashes.push_back(line.mask_hash);
    result.duration = rig.plant.now() - TimePoint();
    return result;
  }();
  return whole;
}

/// Runs the rig to the end of its print. @returns how often the power was cut
int print_with_cuts(Rig& rig) {
  int cuts = 0;
  for (;;) {
    const PrintReport& report = rig.run();
    for (const auto& line : report.exposures) {
      EXPECT_EQ(line.mask_hash, reference().hashes[line.layer]) << "mask of layer " << line.layer;
    }
    // A print that goes on behind its last layer has no layer that could show a mark.
    if (report.first_layer > 0 && report.first_layer < report.layers) {
      EXPECT_EQ(report.marked_layer, report.first_layer);
    }
    if (report.state != kSuspended) {
      EXPECT_EQ(report.state, kFinished) << report.fault_message.c_str();
      return cuts;
    }
    ++cuts;
    rig.plant.restore_power();
    const auto journal = Journal::open(rig.storage);
    if (!journal) {
      EXPECT_EQ(journal.error().code(), ErrorCode::kTruncated);
      EXPECT_TRUE(rig.plant.lights().empty());
      continue;
    }
    // Every layer in the journal was cured in full. One more may have been, if the cut destroyed its record.
    EXPECT_GE(rig.plant.part().layers().size(), journal->last().next_layer);
    EXPECT_LE(rig.plant.part().layers().size(), journal->last().next_layer + 1);
  }
}

void judge(Rig& rig, int cuts) {
  rig.plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(rig.part(), reference().part);
  // The layer being cured gets its light a second time, at most once per cut; nothing else is wrong.
  EXPECT_LE(rig.plant.objections().size(), static_cast<std::size_t>(cuts)) << rig.objections();
  EXPECT_EQ(rig.objections_of(ObjectionKind::kDoseOff), rig.plant.objections().size()) << rig.objections();
}

TEST(PowerCut, At200InstantsThePrintResumesAtTheRightLayer) {
  std::mt19937_64 random(1234);
  int cut = 0;
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    auto settings = rig_plant();
    Fault fault;
    fault.kind = FaultKind::kPowerCut;
    fault.delay =
        nanoseconds(static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(reference().duration.count())));
    settings.faults.push_back(fault);
    Rig rig(settings);
    const int cuts = print_with_cuts(rig);
    EXPECT_EQ(cuts, 1);
    cut += cuts;
    judge(rig, cuts);
  }
  EXPECT_EQ(cut, 200);
}

TEST(PowerCut, InsideTheJournalsWritesThePrintResumesAtTheRightLayer) {
  std::mt19937_64 random(99);
  for (int write = 1; write <= 2 * static_cast<int>(Rig::kLayers); ++write) {
    SCOPED_TRACE(write);
    Rig rig;
    rig.storage.cut_in_write = write;
    rig.storage.cut_after_bytes = random() % Journal::kRecordBytes;
    const int cuts = print_with_cuts(rig);
    EXPECT_EQ(cuts, 1);
    judge(rig, cuts);
  }
}

TEST(PowerCut, AgainAndAgainThePartIsStillTheSame) {
  auto settings = rig_plant();
  for (int i = 1; i <= 12; ++i) {
    Fault fault;
    fault.kind = FaultKind::kPowerCut;
    fault.delay = std::chrono::seconds(70) * i;
    settings.faults.push_back(fault);
  }
  Rig rig(settings);
  const int cuts = print_with_cuts(rig);
  EXPECT_GE(cuts, 6);
  judge(rig, cuts);
}

TEST(PowerCut, ADamagedJournalIsNotResumed) {
  auto settings = rig_plant();
  settings.faults.push_back(parse_fault("power.cut@layer=20").value());
  Rig rig(settings);
  EXPECT_EQ(rig.run().state, kSuspended);
  rig.plant.restore_power();
  for (const std::size_t copy : {0U, 1U}) {
    rig.storage.medium()[copy * Journal::copy_bytes(Rig::kLayers) + 5 * Journal::kRecordBytes + 9] ^= std::byte{4};
  }
  EXPECT_EQ(Journal::open(rig.storage).error().code(), ErrorCode::kMalformed);
}

}  // namespace
}  // namespace plumbline::firmware
