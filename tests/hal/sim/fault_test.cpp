#include "hal/sim/plant/fault.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

namespace plumbline {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(Fault, ParsesItsText) {
  const Fault layer = parse_fault("lamp.stuck_on@layer=40").value();
  EXPECT_EQ(layer.kind, FaultKind::kLampStuckOn);
  EXPECT_EQ(layer.layer, 40U);
  EXPECT_EQ(layer.delay, 0ns);
  EXPECT_FALSE(layer.lasts);

  const Fault time = parse_fault("cover.opens@t=123.4s,for=5s").value();
  EXPECT_EQ(time.kind, FaultKind::kCoverOpens);
  EXPECT_FALSE(time.layer);
  EXPECT_EQ(time.delay, 123400ms);
  EXPECT_EQ(time.lasts, 5s);

  const Fault all = parse_fault("stage.skips@layer=0+1.5s,by=-0.25,for=0.5s").value();
  EXPECT_EQ(all.layer, 0U);
  EXPECT_EQ(all.delay, 1500ms);
  EXPECT_EQ(all.lasts, 500ms);
  EXPECT_EQ(all.amount, -0.25);
}

TEST(Fault, TakesTheTablesAmountByDefault) {
  for (const FaultRow& row : fault_table()) {
    EXPECT_EQ(parse_fault(std::string(row.name) + "@layer=3").value().amount, row.amount) << row.name;
    EXPECT_EQ(parse_fault(std::string(row.name) + "@t=3s").value().kind, row.kind);
  }
}

TEST(Fault, ReportsWhatIsWrongWithItsText) {
  const std::pair<const char*, const char*> wrong[] = {
      {"", "unknown"},
      {"lamp.stuck@layer=4", "did you mean lamp.stuck_on?"},
      {"stage.skip@layer=4", "did you mean stage.skips?"},
      {"lamp.dead", "add a time"},
      {"lamp.dead@", "add a time"},
      {"lamp.dead@soon", "add a time"},
      {"lamp.dead@layer=", "whole number"},
      {"lamp.dead@layer=-1", "whole number"},
      {"lamp.dead@layer=4x", "whole number"},
      {"lamp.dead@layer=4+", "seconds"},
      {"lamp.dead@layer=4+2", "seconds"},
      {"lamp.dead@t=5", "seconds"},
      {"lamp.dead@t=-5s", "seconds"},
      {"lamp.dead@t=nans", "seconds"},
      {"lamp.dead@t=1e300s", "seconds"},
      {"lamp.dead@t=5s,", "comma"},
      {"lamp.dead@t=5s,until=6s", "comma"},
      {"lamp.dead@t=5s,for=x", "for="},
      {"lamp.dead@t=5s,by=2", "no amount"},
      {"lamp.weak@t=5s,by=3", "by= takes 0 to 2"},
      {"lamp.weak@t=5s,by=", "by= takes"},
      {"lamp.weak@t=5s by=0.5", "seconds"},
  };
  for (const auto& [text, says] : wrong) {
    const auto fault = parse_fault(text);
    ASSERT_FALSE(fault) << text;
    EXPECT_EQ(fault.error().code(), ErrorCode::kBadSetting) << text;
    EXPECT_THAT(fault.error().message(), HasSubstr(says)) << text;
  }
}

TEST(Fault, TableHasDifferentNamesAndMatchesTheReadme) {
  std::ifstream file(PLUMBLINE_SOURCE_DIR "/hal/sim/README.md");
  std::stringstream readme;
  readme << file.rdbuf();
  std::set<std::string_view> names;
  for (const FaultRow& row : fault_table()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    std::ostringstream line;
    line << "| `" << row.name << "` | " << (row.moment == FaultMoment::kBeforeLayer ? "before" : "in exposure")
         << " | ";
    if (row.by.empty()) {
      line << "-";
    } else {
      line << row.amount << " " << row.by;
    }
    line << " | " << row.what << " |\n";
    EXPECT_THAT(readme.str(), HasSubstr(line.str()));
  }
  EXPECT_GE(names.size(), 30U);
}

}  // namespace
}  // namespace plumbline
