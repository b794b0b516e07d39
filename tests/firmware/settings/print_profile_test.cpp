#include "firmware/settings/print_profile.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "firmware/settings/board_file.hpp"
#include "firmware/settings/settings_file.hpp"

namespace plumbline::firmware {
namespace print_profile_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kStandard = PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml";

std::string standard_with(const std::string& from, const std::string& to) {
  auto text = read_settings_text(kStandard, "a profile").value();
  const auto at = text.find(from);
  if (at == std::string::npos) ADD_FAILURE() << from << " is not in standard.toml";
  return text.replace(at, from.size(), to);
}

std::string refusal(const std::string& text) {
  const auto profile = parse_print_profile(text, "p.toml");
  EXPECT_FALSE(profile) << "was accepted:\n" << text;
  return profile ? std::string() : profile.error().message();
}

TEST(PrintProfile, LoadsEveryFile) {
  int profiles = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PLUMBLINE_SOURCE_DIR "/board/profiles")) {
    const auto profile = read_print_profile(entry.path().string());
    ASSERT_TRUE(profile) << profile.error().message();
    EXPECT_EQ(profile->name, entry.path().stem().string());
    ++profiles;
  }
  EXPECT_GE(profiles, 3);
}

TEST(PrintProfile, ReadsEveryValue) {
  const auto p = read_print_profile(kStandard);
  ASSERT_TRUE(p);
  EXPECT_EQ(p->layer_height, 0.05);
  EXPECT_EQ(p->exposure_time, 2.5);
  EXPECT_EQ(p->initial_exposure_time, 30);
  EXPECT_EQ(p->bottom_layer_count, 5U);
  EXPECT_EQ(p->faded_layers, 8U);
  EXPECT_EQ(p->lift_height2, 3);
  EXPECT_EQ(p->retract_speed2, 60);
  EXPECT_EQ(p->penetration_depth, 0.12);
  EXPECT_EQ(p->critical_energy, 3.2);
  EXPECT_EQ(p->bottle_cost, 30);
}

TEST(PrintProfile, CorrectsSizesByPrinterAndResin) {
  auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value();
  board.relative_correction = {1.01, 1.02, 0.99};
  auto profile = parse_print_profile(standard_with("material_correction_z = 1.0", "material_correction_z = 1.05"), "p");
  ASSERT_TRUE(profile) << profile.error().message();
  profile->absolute_correction = -0.02;
  profile->exchange = 0;
  SliceSettings plain, settings;
  for (SliceSettings* const each : {&plain, &settings}) each->placement.printer = printer_volume(board);
  correct_sizes(*profile, board, settings);
  const double high = 0.99 * 1.05;
  EXPECT_TRUE(settings.placement.correction.isApprox(Vec3d(1.01, 1.02, high)));
  EXPECT_EQ(settings.absolute_correction_mm, -0.02);
  EXPECT_NEAR(static_cast<double>(settings.placement.printer->pitch_y_mm), 0.04725 / 1.02, 1e-8);
  EXPECT_NEAR(static_cast<double>(settings.placement.layer_height_mm), 0.05 / high, 1e-8);
  // Light goes as deep as before, which is less of what shrinks from larger masks.
  tell_checks(*profile, *board.machine, plain);
  tell_checks(*profile, *board.machine, settings);
  EXPECT_NEAR(settings.cure.penetration_mm, plain.cure.penetration_mm / high, 1e-12);
  EXPECT_NEAR(settings.overcure_mm, plain.overcure_mm / high, 1e-8);
}

TEST(PrintProfile, RefusesCorrectionsThatAreMistakes) {
  EXPECT_THAT(refusal(standard_with("material_correction_x = 1.0 ", "material_correction_x = 101 ")),
              HasSubstr("material_correction_x: found an integer 101, allowed is a number from 0.9 to 1.1"));
  EXPECT_THAT(refusal(standard_with("absolute_correction = 0.0", "absolute_correction = -20.0")),
              HasSubstr("absolute_correction: found a float -20, allowed is a number from -0.5 to 0.5 mm"));
}

TEST(PrintProfile, DoesNotNeedTheCostOfABottle) {
  auto text = standard_with("bottle_cost", "# bottle_cost");
  const auto profile = parse_print_profile(text, "p.toml");
  ASSERT_TRUE(profile) << profile.error().message();
  EXPECT_EQ(profile->bottle_cost, 0);
}

TEST(PrintProfile, SaysWhatHappensToIssues) {
  const auto usual = read_print_profile(kStandard);
  ASSERT_TRUE(usual);
  EXPECT_EQ(usual->checks.actions, CheckPolicy().actions) << "the file shows the defaults";
  const auto strict = parse_print_profile(standard_with("resin_trap = \"warn\"", "resin_trap = \"refuse\""), "p.toml");
  ASSERT_TRUE(strict) << strict.error().message();
  EXPECT_EQ(strict->checks.of(IssueKind::kResinTrap), CheckAction::kRefuse);
  EXPECT_EQ(strict->checks.of(IssueKind::kIsland), CheckAction::kWarn);
  EXPECT_THAT(
      refusal(standard_with("resin_trap = \"warn\"", "resin_trap = \"shout\"")),
      HasSubstr("resin_trap: found a string 'shout', allowed is one of the strings ignore, warn, ask or refuse"));
}

TEST(CheckChoice, ChangesThePolicyAndAcceptsWhatItAsksAbout) {
  CheckPolicy policy;
  policy.of(IssueKind::kIsland) = CheckAction::kAsk;
  CheckChoice choice;
  choice.actions[static_cast<std::size_t>(IssueKind::kOverhang)] = CheckAction::kAsk;
  choice.actions[static_cast<std::size_t>(IssueKind::kSuctionCup)] = CheckAction::kRefuse;
  EXPECT_EQ(choice.over(policy).of(IssueKind::kIsland), CheckAction::kAsk);
  choice.accept = true;
  const CheckPolicy accepted = choice.over(policy);
  EXPECT_EQ(accepted.of(IssueKind::kIsland), CheckAction::kWarn);
  EXPECT_EQ(accepted.of(IssueKind::kOverhang), CheckAction::kWarn);
  EXPECT_EQ(accepted.of(IssueKind::kSuctionCup), CheckAction::kRefuse);
  EXPECT_EQ(accepted.of(IssueKind::kPrintHeight), CheckAction::kRefuse);
}

TEST(PrintProfile, RefusesAMisspeltKeyAWrongUnitAndAWrongRange) {
  EXPECT_THAT(refusal(standard_with("exposure_time", "exposure_tme")),
              AllOf(StartsWith("p.toml:"), HasSubstr("[print] exposure_tme: unknown key; the nearest known one is "
                                                     "exposure_time")));
  EXPECT_THAT(refusal(standard_with("layer_height = 0.05", "layer_height = \"50 um\"")),
              HasSubstr("[print] layer_height: found a string '50 um', allowed is a number from 0.005 to 1 mm"));
  EXPECT_THAT(refusal(standard_with("layer_height = 0.05", "layer_height = 50")),
              HasSubstr("found an integer 50, allowed is a number from 0.005 to 1 mm"));
  EXPECT_THAT(refusal(standard_with("faded_layers = 8", "faded_layers = 8.5")), HasSubstr("allowed is an integer"));
  EXPECT_THAT(refusal(standard_with("retract_height2 = 2.0", "retract_height2 = 7.1")),
              HasSubstr("retract_height2: found a float 7.1, allowed is at most the whole lift"));
}

/// A row of the tables in board/README.md.
struct Row {
  std::string table;
  std::string key;
  std::string allowed;
};

std::vector<Row> documented() {
  std::vector<Row> rows;
  std::istringstream text(read_settings_text(PLUMBLINE_SOURCE_DIR "/board/README.md", "a page").value());
  const std::regex row(R"(^\| `\[(\w+)\] (\w+)`[ *+]*\| ([^|]*) \|.*)");
  for (std::string line; std::getline(text, line);) {
    std::smatch match;
    if (std::regex_match(line, match, row)) rows.push_back({match[1], match[2], match[3]});
  }
  return rows;
}

std::set<std::string> keys_in(const std::string& path) {
  std::set<std::string> keys;
  std::string table;
  std::istringstream text(read_settings_text(path, "").value());
  const std::regex key(R"(^(\w+) = .*)");
  const std::regex heading(R"(^\[(\w+)\])");
  for (std::string line; std::getline(text, line);) {
    std::smatch match;
    if (std::regex_match(line, match, heading)) table = match[1];
    if (std::regex_match(line, match, key)) keys.insert(table + " " + match[1].str());
  }
  return keys;
}

TEST(BoardReadme, ExplainsEveryKeyAndNoOther) {
  std::set<std::string> explained;
  for (const auto& row : documented()) explained.insert(row.table + " " + row.key);
  auto known = keys_in(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml");
  known.merge(keys_in(PLUMBLINE_SOURCE_DIR "/board/mono2k.toml"));
  known.merge(keys_in(kStandard));
  known.insert("printer page_host");        // only some networks have one
  known.insert("panel lamp_map");           // only measured lamps have one
  known.insert("supports support_preset");  // sets three of the others
  EXPECT_EQ(explained, known);
}

/// Replaces the value of a key, whatever it was.
std::string with_value(const std::string& text, const std::string& table, const std::string& key,
                       const std::string& value) {
  const auto at = text.find("\n" + key + " = ", text.find("[" + table + "]")) + 1;
  const auto end = text.find('\n', at);
  return text.substr(0, at) + key + " = " + value + text.substr(end);
}

TEST(BoardReadme, GivesTheRangesThatTheProgramChecks) {
  const auto sim2k = read_settings_text(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml", "").value();
  const auto standard = read_settings_text(kStandard, "").value();
  int checked = 0;
  for (const auto& row : documented()) {
    std::smatch range;
    if (!std::regex_search(row.allowed, range, std::regex(R"((integer, )?(-?[\d.]+) to ([\d.]+))"))) continue;
    if (row.key == "name" || row.key == "profile" || row.key == "page_host") continue;  // the range counts characters
    const bool is_board = sim2k.find("[" + row.table + "]") != std::string::npos &&
                          sim2k.find("\n" + row.key + " = ") != std::string::npos;
    const std::string text = with_value(is_board ? sim2k : standard, row.table, row.key, "1000000000");
    const std::string said =
        is_board ? parse_board_file(text, "x").error().message() : parse_print_profile(text, "x").error().message();
    const std::string type = range[1].matched ? "an integer from " : "a number from ";
    EXPECT_THAT(said, HasSubstr(row.key + ": found an integer 1000000000, allowed is " + type + range[2].str() +
                                " to " + range[3].str()));
    ++checked;
  }
  EXPECT_GE(checked, 35);
}

}  // namespace print_profile_test
}  // namespace plumbline::firmware
