#include "firmware/machine/back_end.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

/// Why a printer can't be opened, found without opening anything; empty: it may be there.
std::string objection(const char* printer, const SimulationOptions& options = {}) {
  const auto board = read_board_file(std::string(PLUMBLINE_SOURCE_DIR "/board/") + printer + ".toml");
  EXPECT_TRUE(board) << board.error().message();
  const auto checked = check_back_end(*board, *board->machine, options);
  return checked ? std::string() : checked.error().message();
}

TEST(BackEnd, IsRefusedBeforeASliceForWhatItsFileAndOptionsSay) {
  EXPECT_EQ(objection("sim2k"), "");
  SimulationOptions options;
  options.faults = {"lamp.explodes"};
  EXPECT_THAT(objection("sim2k", options), HasSubstr("lamp.explodes"));
  options = {};
  options.lamp_line = "file:x";
  EXPECT_THAT(objection("sim2k", options), HasSubstr("add --realtime or --speedup N"));
  options.speedup = 1;
  EXPECT_EQ(objection("sim2k", options), "");
  options = {};
  options.simulate = true;
  EXPECT_EQ(objection("mono2k", options), "");
  const std::string unwired = objection("mono2k");
  if (unwired.find("this build drives simulated printers only") != std::string::npos) {
    GTEST_SKIP() << "built without board devices";
  }
  EXPECT_THAT(unwired, HasSubstr("its board file does not say how the printer is wired: [display], [lamp_line]"));
  EXPECT_EQ(objection("rig"), "");
}

}  // namespace
}  // namespace plumbline::firmware
