#include "firmware/cli/doctor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using testing::HasSubstr;
using Verdict = MachineFinding::Verdict;

const std::array<MachineFinding, 3> kFindings = {
    MachineFinding{Verdict::kGood, "the lamp's line", "gpiochip0 line 17", ""},
    MachineFinding{Verdict::kPoor, "locked memory", "not permitted", "give it CAP_IPC_LOCK"},
    MachineFinding{Verdict::kWrong, "the panel", "no \"DSI-1\"", "see to its cable"}};

/// The text that a writer puts into a file.
template <class Write>
std::string written(Write&& write) {
  const TemporaryFolder folder;
  const std::string path = folder / "findings";
  {
    auto file = OutputFile::create(path.c_str());
    EXPECT_TRUE(file);
    EXPECT_TRUE(write(*file));
    EXPECT_TRUE(file->close());
  }
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Doctor, ReportsWhatWasFoundAndWhatToDo) {
  EXPECT_EQ(written([](OutputFile& out) { return write_findings(out, "mine", kFindings); }),
            "printer mine\n"
            "  ok     the lamp's line  gpiochip0 line 17\n"
            "  poor   locked memory    not permitted\n"
            "         -> give it CAP_IPC_LOCK\n"
            "  WRONG  the panel        no \"DSI-1\"\n"
            "         -> see to its cable\n"
            "1 good, 1 poor, 1 wrong: it can't print until what is wrong is fixed\n");
}

TEST(Doctor, SaysThatItPrintsIfNothingIsWrong) {
  EXPECT_FALSE(prints(kFindings));
  const auto two = std::span(kFindings).first(2);
  EXPECT_TRUE(prints(two));
  EXPECT_THAT(written([&](OutputFile& out) { return write_findings(out, "mine", two); }),
              HasSubstr("1 good, 1 poor, 0 wrong: ready to print\n"));
}

TEST(Doctor, ReportsTheSameAsJson) {
  const auto text = written([](OutputFile& out) { return write_findings_json(out, "mine", kFindings); });
  EXPECT_THAT(text, HasSubstr("\"prints\": false"));
  EXPECT_THAT(text, HasSubstr("\"verdict\": \"poor\""));
  EXPECT_THAT(text, HasSubstr("\"found\": \"no \\\"DSI-1\\\"\""));
}

TEST(Doctor, RefusesASimulatedPrinter) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value();
  const auto findings = examine_machine(board, *board.machine);
  ASSERT_FALSE(findings);
  EXPECT_EQ(findings.error().code(), ErrorCode::kUnsupported);
}

#ifdef PLUMBLINE_HAS_BOARD_DEVICES
TEST(Doctor, FindsWhatABoardWithoutAPrinterLacks) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/mono2k.toml").value();
  const auto findings = examine_machine(board, *board.machine);
  ASSERT_TRUE(findings) << findings.error().message();
  EXPECT_FALSE(prints(*findings));
  int wrong = 0;
  for (const auto& one : *findings) {
    EXPECT_FALSE(one.what.empty() || one.found.empty());
    EXPECT_EQ(one.advice.empty(), one.verdict == Verdict::kGood) << one.what;
    wrong += one.verdict == Verdict::kWrong ? 1 : 0;
  }
  EXPECT_GE(wrong, 8) << "lamp, step, direction, end stop, panel, three sensors";
}

TEST(Doctor, ChecksThatTheWatchdogIsADeviceThatCanBeWritten) {
  auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/mono2k.toml").value();
  const auto check = [&](const char* device) {
    board.machine->wiring.watchdog.device = device;
    const auto findings = examine_machine(board, *board.machine).value();
    return *std::find_if(findings.begin(), findings.end(), [](const auto& one) { return one.what == "the watchdog"; });
  };
  EXPECT_EQ(check("").verdict, Verdict::kPoor) << "it prints without one";
  EXPECT_EQ(check("/dev/null").verdict, Verdict::kGood) << "any device that can be written";
  EXPECT_THAT(check(PLUMBLINE_SOURCE_DIR "/README.md").found, HasSubstr("is no device"));
  const MachineFinding missing = check("/dev/no-watchdog");
  EXPECT_EQ(missing.verdict, Verdict::kWrong);
  EXPECT_THAT(missing.found, HasSubstr("No such file"));
}

TEST(BackEnd, RefusesABoardFileWithoutWiring) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/mono2k.toml").value();
  const auto opened = open_back_end(board, *board.machine, {}, {});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code(), ErrorCode::kBadSetting);
  EXPECT_THAT(opened.error().message(),
              testing::AllOf(HasSubstr("[lamp_line]"), HasSubstr("[cover_line]"), HasSubstr("--simulate")));
}
#endif

}  // namespace
}  // namespace plumbline::firmware
