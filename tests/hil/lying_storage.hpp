#pragma once
/// Prints on storage that has called writes durable and loses them when the power goes.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/hil/rig.hpp"

namespace plumbline::firmware {

inline constexpr nanoseconds kPrint = std::chrono::seconds(400);

inline PlantSettings with_cut_at(nanoseconds time) {
  auto settings = rig_plant();
  Fault fault;
  fault.kind = FaultKind::kPowerCut;
  fault.delay = time;
  settings.faults.push_back(fault);
  return settings;
}

struct Tally {
  int resumed = 0;    ///< at the right layer, without a question
  int confirmed = 0;  ///< at the right layer, after the user has measured the part
  int given_up = 0;   ///< by the user, who found the part taller
  int refused = 0;    ///< the journal, in words, since its copies disagree
};

/// Cuts the power at a random instant, loses the last writes, and resumes.
inline void lose_and_resume(std::mt19937_64& random, Tally& tally) {
  Rig rig(with_cut_at(nanoseconds(static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(kPrint.count())))));
  if (rig.run().state != PrintState::kSuspended) return;
  const auto cured = static_cast<std::uint32_t>(rig.plant.part().layers().size());
  const bool in_order = random() % 2 == 0;
  rig.storage.lose(std::min<std::size_t>(random() % 12, rig.storage.writes()),
                   [&] { return in_order || random() % 2 == 0; });
  rig.plant.restore_power();
  const auto most = rig.plant.settings().travel.drift.nanometres();
  rig.plant.stage().drift(
      Distance::nanometres(static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(2 * most + 1)) - most));
  const auto journal = Journal::open(rig.storage);
  if (!journal) {
    EXPECT_FALSE(in_order) << journal.error().message();
    EXPECT_EQ(journal.error().code(), ErrorCode::kMalformed);
    ++tally.refused;
    return;
  }
  rig.user.measures_part = true;
  const std::uint32_t first = journal->last().next_layer;
  const PrintReport& report = rig.run();
  EXPECT_EQ(rig.objections_of(ObjectionKind::kTravelPastEnd), 0U) << "the part was pressed into the film";
  if (report.state == PrintState::kCancelled) {
    EXPECT_EQ(rig.user.questions.size(), 1U);
    EXPECT_LT(first + 1, cured) << "the user has found a part that is too tall";
    EXPECT_TRUE(report.exposures.empty());
    ++tally.given_up;
    return;
  }
  EXPECT_EQ(report.state, PrintState::kFinished) << report.fault_message.c_str();
  // The last layer may be cured again: it may have been in the light when the power went.
  EXPECT_TRUE(first == cured || first + 1 == cured) << first << " of " << cured;
  ++(rig.user.questions.empty() ? tally.resumed : tally.confirmed);
}

inline Tally lose_and_resume(int rounds, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Tally tally;
  for (int round = 0; round < rounds && !::testing::Test::HasFailure(); ++round) {
    SCOPED_TRACE(round);
    lose_and_resume(random, tally);
  }
  return tally;
}

}  // namespace plumbline::firmware
