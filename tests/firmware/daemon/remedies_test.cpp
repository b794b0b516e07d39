#include "firmware/daemon/remedies.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "firmware/daemon/stick/job_setting.hpp"
#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> words(const Remedies& remedies) {
  std::vector<std::string> all;
  for (const Remedy& one : std::span(remedies.list).first(remedies.count)) {
    all.push_back(std::string(one.key.view()) + " = " + std::string(one.value.view()));
  }
  return all;
}

TEST(Remedies, AddSupportsOrFindABetterWayUp) {
  JobSettings job;
  EXPECT_THAT(words(remedies_of(PrinterCode::kIsland, job, false)), ElementsAre("supports = auto"));
  EXPECT_THAT(words(remedies_of(PrinterCode::kOverhang, job, true)), ElementsAre("orient = auto"));
  job.rotate_x_deg = 10;
  EXPECT_THAT(words(remedies_of(PrinterCode::kOverhang, job, true)), IsEmpty()) << "somebody has turned it already";
}

TEST(Remedies, StandItUpAsTheScanShows) {
  const JobSettings job;
  EXPECT_THAT(words(remedies_of({PrinterCode::kLiesWrong, {{Fact::kTurnXDeg, -90}}}, job, true)),
              ElementsAre("rotate_x_deg = -90"));
  EXPECT_THAT(words(remedies_of({PrinterCode::kLiesWrong, {{Fact::kTurnYDeg, 90}}}, job, true)),
              ElementsAre("rotate_y_deg = 90"));
  EXPECT_THAT(words(remedies_of({PrinterCode::kLiesWrong, {{Fact::kTurnXDeg, 90}, {Fact::kTurnYDeg, 90}}}, job, true)),
              ElementsAre("orient = auto"));
}

TEST(Remedies, OfferOtherUnits) {
  JobSettings job;
  EXPECT_THAT(words(remedies_of({PrinterCode::kObjectSmall, {}, "units"}, job, true)),
              ElementsAre("units = cm", "units = m", "units = in"));
  EXPECT_THAT(words(remedies_of({PrinterCode::kUnitsGuessed, {}, "m"}, job, true)),
              ElementsAre("units = mm", "units = cm", "units = in"));
  EXPECT_THAT(words(remedies_of(PrinterCode::kObjectSmall, job, true)), IsEmpty()) << "the file is in mm";
  job.size = PrintSize{Side::kHeight, 80};
  EXPECT_THAT(words(remedies_of({PrinterCode::kObjectSmall, {}, "units"}, job, true)), IsEmpty());
}

TEST(Remedies, AskForMoreWhereSomeIsLost) {
  JobSettings job;
  job.size = PrintSize{Side::kHeight, 40};
  const Told told(PrinterCode::kSizeOff, {{PrinterFact::kAskedMm, 40}, {PrinterFact::kDeliveredMm, 39.85}});
  EXPECT_THAT(words(remedies_of(told, job, true)), ElementsAre("height = 40.15mm"));
}

// What a button sends must be taken.
TEST(Remedies, AreSettingsOfAJob) {
  JobSettings sized;
  sized.size = PrintSize{Side::kLength, 40};
  for (const JobSettings& job : {JobSettings(), sized}) {
    for (std::size_t code = 0; code < 200; ++code) {
      for (const char* name : {"units", "mm", ""}) {
        const Told told(static_cast<ToldCode>(code),
                        {{Fact::kTurnXDeg, 90}, {PrinterFact::kAskedMm, 40}, {PrinterFact::kDeliveredMm, 39}}, name);
        for (const bool supports : {false, true}) {
          const Remedies remedies = remedies_of(told, job, supports);
          for (const Remedy& one : std::span(remedies.list).first(remedies.count)) {
            StickJob stick;
            EXPECT_TRUE(set_job_setting(stick, one.key.view(), one.value.view()))
                << one.key.c_str() << " " << one.value.c_str();
            EXPECT_FALSE(one.key.cut() || one.value.cut());
          }
        }
      }
    }
  }
}

TEST(IssuePlaces, AreTheLargestOfAKind) {
  StackFindings findings;
  PrintGrid grid;
  grid.columns = grid.rows = grid.layers = 100;
  auto& group = findings.groups[static_cast<std::size_t>(IssueKind::kIsland)];
  for (std::uint32_t i = 0; i < 12; ++i)
    group.add({.kind = IssueKind::kIsland, .layer = i, .column = 10, .row = 20, .pixels = i + 1});
  const IssuePlaces places = places_of(IssueKind::kIsland, findings, grid);
  ASSERT_EQ(places.count, 8U);
  EXPECT_NEAR(places.mm[0][0], 0.525, 1e-6);
  EXPECT_NEAR(places.mm[0][1], 1.025, 1e-6);
  EXPECT_NEAR(places.mm[0][2], 0.55, 1e-6);
  EXPECT_EQ(places_of(IssueKind::kEmptyLayer, findings, grid).count, 0U);
}

}  // namespace
}  // namespace plumbline::firmware
