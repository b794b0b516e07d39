#include "firmware/page/octoprint.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "firmware/io/text/json_cursor.hpp"

namespace plumbline::firmware {
namespace {

using Text = TextBuffer<4096>;

/// The example line of the protocol that has a state.
std::string example(const std::string& state) {
  std::ifstream file(PLUMBLINE_SOURCE_DIR "/firmware/state/examples.ndjson");
  for (std::string line; std::getline(file, line);) {
    if (json_member(line, "state") == "\"" + state + "\"") return line;
  }
  ADD_FAILURE() << "no example of " << state;
  return {};
}

std::string member(const Text& text, std::initializer_list<const char*> path) {
  std::string_view at = text.view();
  JsonCursor cursor(at);
  EXPECT_TRUE(cursor.take_value(8) && cursor.at_end()) << text.view();
  for (const char* const key : path) {
    const auto value = json_member(at, key);
    EXPECT_TRUE(value) << key << " of " << text.view();
    at = value.value_or("");
  }
  return std::string(at);
}

TEST(OctoPrint, SaysWhatIsPrinted) {
  const std::string line = example("printing");
  Text job, printer;
  ASSERT_TRUE(write_octoprint_job(job, line));
  EXPECT_EQ(member(job, {"state"}), "\"Printing\"");
  EXPECT_EQ(member(job, {"job", "file", "name"}), "\"gear.ply\"");
  EXPECT_EQ(member(job, {"job", "estimatedPrintTime"}), "1253");
  EXPECT_EQ(member(job, {"progress", "completion"}), "15.00") << "12 of 80 layers";
  EXPECT_EQ(member(job, {"progress", "printTime"}), "448");
  EXPECT_EQ(member(job, {"progress", "printTimeLeft"}), "805");
  ASSERT_TRUE(write_octoprint_printer(printer, line));
  EXPECT_EQ(member(printer, {"state", "flags", "printing"}), "true");
  EXPECT_EQ(member(printer, {"state", "flags", "operational"}), "true");
  EXPECT_EQ(member(printer, {"state", "flags", "paused"}), "false");
  EXPECT_EQ(member(printer, {"state", "flags", "error"}), "false");
}

TEST(OctoPrint, SaysWhatIsNot) {
  Text job, printer, version, fault, offered;
  ASSERT_TRUE(write_octoprint_job(job, ""));
  EXPECT_EQ(member(job, {"state"}), "\"Offline\"");
  EXPECT_EQ(member(job, {"progress", "completion"}), "null");
  ASSERT_TRUE(write_octoprint_printer(printer, ""));
  EXPECT_EQ(member(printer, {"state", "flags", "closedOrError"}), "true");
  ASSERT_TRUE(write_octoprint_version(version));
  EXPECT_EQ(member(version, {"api"}), "\"0.1\"");
  ASSERT_TRUE(write_octoprint_printer(fault, example("fault")));
  EXPECT_EQ(member(fault, {"state", "flags", "error"}), "true");
  ASSERT_TRUE(write_octoprint_printer(offered, example("offered")));
  EXPECT_EQ(member(offered, {"state", "flags", "ready"}), "true");
  TextBuffer<20> small;
  EXPECT_FALSE(write_octoprint_version(small));
}

}  // namespace
}  // namespace plumbline::firmware
