#include "firmware/print/status/print_lines.hpp"

#include <gtest/gtest.h>

#include <string>

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;

TEST(PrintLines, SayWhichLayerIsPrintedOrWhatThePrintWaitsFor) {
  PrintStatus status;
  status.layer = 11;
  status.layers = 1184;
  status.remaining = 2h + 10min + 10s;
  const auto text = [&status](PrintState state) {
    status.state = state;
    return std::string(status_text(status).view());
  };
  EXPECT_EQ(text(PrintState::kHoming), "homing");
  EXPECT_EQ(text(PrintState::kPrinting), "printing layer 12 of 1184, 2 h 10 min left");
  EXPECT_EQ(text(PrintState::kPaused), "paused at layer 12 of 1184: press start to go on");
  EXPECT_EQ(text(PrintState::kCoverOpen), "paused at layer 12 of 1184: the cover is open, close it");
  EXPECT_NE(text(PrintState::kCoolingDown).find("goes on by itself"), std::string::npos);
  EXPECT_NE(text(PrintState::kFeedMe).find("pour in resin"), std::string::npos);
  status.question = "the part must be 0.60 mm tall";
  EXPECT_EQ(text(PrintState::kPaused), "paused at layer 12 of 1184: the part must be 0.60 mm tall");
  EXPECT_EQ(text(PrintState::kPrinting), "printing layer 12 of 1184, 2 h 10 min left");
  EXPECT_EQ(text(PrintState::kCoverOpen), "paused at layer 12 of 1184: the cover is open, close it");
  status.question = {};
  status.layer = 1184;
  EXPECT_EQ(text(PrintState::kPaused), "paused at layer 1184 of 1184: press start to go on") << "all are cured";
}

}  // namespace
}  // namespace plumbline::firmware
