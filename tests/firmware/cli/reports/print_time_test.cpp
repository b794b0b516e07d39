#include "firmware/cli/reports/print_time.hpp"

#include <gtest/gtest.h>

#include "firmware/print/job/print_plan.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;

TEST(PrintTime, IsGivenInTenMinutesAboveAnHour) {
  EXPECT_EQ((PrintTime{4h + 6min, "standard"}.text()), "about 4 h 10 min with the profile standard");
  EXPECT_EQ((PrintTime{59min + 40s, "draft"}.text()), "about 1 h 00 min with the profile draft");
  EXPECT_EQ((PrintTime{20s, "draft"}.text()), "about 1 min with the profile draft");
}

TEST(PrintTime, IsThatOfThePlanWithTheBoardsProfile) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value();
  const auto profile = read_print_profile("standard", board.path).value();
  const auto estimate = estimate_print_time(board, 100, 0.05);
  ASSERT_TRUE(estimate);
  EXPECT_EQ(estimate->profile, "standard");
  EXPECT_EQ(estimate->time, print_time(plan_print(profile, *board.machine, 0.05, 100).value()));
}

TEST(PrintTime, IsUnknownWhereTheBoardFileDescribesNoMachine) {
  auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value();
  board.machine.reset();
  EXPECT_FALSE(estimate_print_time(board, 100, 0.05));
}

}  // namespace
}  // namespace plumbline::firmware
