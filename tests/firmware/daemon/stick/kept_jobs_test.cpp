/// What people have set for each scan stays until its stick leaves.

#include "firmware/daemon/stick/kept_jobs.hpp"

#include <gtest/gtest.h>

#include <string>

namespace plumbline::firmware {
namespace {

StickJob plain_job(const std::string& name) {
  StickJob job;
  job.scans = {name};
  return job;
}

StickEntry listed(const StickJob& job, std::uint64_t bytes, std::int64_t modified = 0) {
  return {job.scans, bytes, modified};
}

StickJob turned(StickJob job, double degrees) {
  job.rotate_x_deg = degrees;
  return job;
}

TEST(KeptJobs, EachScanHasItsOwnSettings) {
  KeptJobs kept;
  const StickJob a = plain_job("a.ply"), b = plain_job("b.ply");
  EXPECT_EQ(kept.take(listed(a, 10), false, a), a);
  kept.keep(turned(a, 30));
  EXPECT_EQ(kept.take(listed(b, 10), false, b), b);
  EXPECT_EQ(kept.plain(), b);
  kept.keep(turned(b, 60));
  EXPECT_EQ(kept.take(listed(a, 10), false, a), turned(a, 30));
  EXPECT_EQ(kept.plain(), a);
  kept.keep(turned(a, 40));
  EXPECT_EQ(kept.take(listed(a, 10), false, a), turned(a, 40)) << "the last";
  EXPECT_EQ(kept.take(listed(b, 10), false, b), turned(b, 60));
  kept.keep(b);
  EXPECT_EQ(kept.take(listed(b, 10), false, b), b) << "taken back";
}

TEST(KeptJobs, AnotherFileOfThatNameIsAnotherScan) {
  KeptJobs kept;
  const StickJob a = plain_job("a.ply");
  kept.take(listed(a, 10), false, a);
  kept.keep(turned(a, 30));
  EXPECT_EQ(kept.take(listed(a, 11), false, a), a) << "of another size";
  EXPECT_EQ(kept.take(listed(a, 10, 1'700'000'000), false, a), a) << "of another day";
  EXPECT_EQ(kept.take(listed(a, 10), true, a), a) << "uploaded";
  StickJob series = a;
  series.scans.emplace_back("b.ply");
  EXPECT_EQ(kept.take(listed(series, 10), false, series), series) << "a series that begins with it";
  EXPECT_EQ(kept.take(listed(a, 10), false, a), turned(a, 30));
}

TEST(KeptJobs, GoWithTheirStickOrTheUploadedScan) {
  for (const bool uploaded : {false, true}) {
    KeptJobs kept;
    const StickJob a = plain_job("a.ply");
    for (const bool which : {!uploaded, uploaded}) {
      kept.take(listed(a, 10), which, a);
      kept.keep(turned(a, 30));
    }
    EXPECT_TRUE(kept.at_hand(listed(a, 10), uploaded));
    EXPECT_FALSE(kept.at_hand(listed(a, 10), !uploaded));
    kept.forget(!uploaded);
    EXPECT_TRUE(kept.at_hand(listed(a, 10), uploaded));
    kept.forget(uploaded);
    EXPECT_FALSE(kept.at_hand(listed(a, 10), uploaded));
    EXPECT_EQ(kept.take(listed(a, 10), false, a), a);
    EXPECT_EQ(kept.take(listed(a, 10), true, a), a);
  }
}

// Whoever looks again at a print and puts its stick back in gets its settings.
TEST(KeptJobs, AreKeptOfAScanWhoseStickCameBack) {
  KeptJobs kept;
  const StickJob a = plain_job("a.ply");
  kept.take(listed(a, 10), false, a);
  kept.forget(false);
  kept.keep(turned(a, 30));
  EXPECT_TRUE(kept.at_hand(listed(a, 10), false));
  EXPECT_EQ(kept.take(listed(a, 10), false, a), turned(a, 30));
}

// A stick may come while the printer is too busy to see the one before leave.
TEST(KeptJobs, AnotherJobFileCountsThoughItsScanIsTheSame) {
  KeptJobs kept;
  const StickJob a = plain_job("a.ply");
  kept.take(listed(a, 0), false, a);
  kept.keep(turned(a, 30));
  EXPECT_EQ(kept.take(listed(a, 0), false, a), turned(a, 30));
  const StickJob other = turned(a, 5);
  EXPECT_EQ(kept.take(listed(a, 0), false, other), other);
}

TEST(KeptJobs, TheOldestGoFirstAndUnchangedOnesTakeNoRoom) {
  KeptJobs kept;
  const auto name = [](std::size_t i) { return "scan" + std::to_string(i) + ".ply"; };
  for (std::size_t i = 0; i <= KeptJobs::kMost; ++i) {
    for (const std::size_t k : {i, 1000 + i}) {
      const StickJob job = plain_job(name(k));
      kept.take(listed(job, 10), false, job);
      kept.keep(k == i ? turned(job, 1) : job);
    }
  }
  for (std::size_t i = 0; i <= KeptJobs::kMost; ++i) {
    EXPECT_EQ(kept.take(listed(plain_job(name(i)), 10), false, plain_job(name(i))).rotate_x_deg, i == 0 ? 0 : 1) << i;
  }
}

}  // namespace
}  // namespace plumbline::firmware
