#include "firmware/settings/board_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "firmware/settings/wiring_file.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr const char* kGood = R"([printer]
name = "test"
[panel]
columns = 1440
rows = 2560
pixel_pitch_x_mm = 0.04725
pixel_pitch_y_mm = 0.05
[z_stage]
travel_mm = 160
[print]
layer_height_mm = 0.05
[memory]
arena_mib = 96
)";

/// kGood with its one occurrence of `from` replaced.
std::string good_with(const std::string& from, const std::string& to) {
  std::string text = kGood;
  const auto at = text.find(from);
  if (at == std::string::npos) ADD_FAILURE() << from << " is not in the good file";
  return text.replace(at, from.size(), to);
}

/// The message of the error, which must have `code`.
std::string refusal(const std::string& text, ErrorCode code = ErrorCode::kBadSetting) {
  const auto board = parse_board_file(text, "b.toml");
  if (board) {
    ADD_FAILURE() << "was accepted:\n" << text;
    return {};
  }
  EXPECT_EQ(board.error().code(), code) << board.error().message();
  return board.error().message();
}

TEST(BoardFile, ReadsEveryValue) {
  const auto board = parse_board_file(kGood, "b.toml");
  ASSERT_TRUE(board) << board.error().message();
  EXPECT_EQ(board->name, "test");
  EXPECT_EQ(board->columns, 1440U);
  EXPECT_EQ(board->rows, 2560U);
  EXPECT_EQ(board->pixel_pitch_x_mm, 0.04725);
  EXPECT_EQ(board->pixel_pitch_y_mm, 0.05);
  EXPECT_EQ(board->travel_mm, 160.0) << "an integer is also a number";
  EXPECT_EQ(board->layer_height_mm, 0.05);
  EXPECT_EQ(board->arena_mib, 96U);
}

TEST(BoardFile, LoadsEveryBoard) {
  int boards = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PLUMBLINE_SOURCE_DIR "/board")) {
    if (entry.path().extension() != ".toml") continue;
    const auto board = read_board_file(entry.path().string());
    ASSERT_TRUE(board) << board.error().message();
    EXPECT_EQ(board->name, entry.path().stem().string());
    EXPECT_TRUE(board->machine) << entry.path() << " can't be printed with";
    ++boards;
  }
  EXPECT_GE(boards, 4);
}

TEST(BoardFile, GivesTheSourceOfEachLineOfARealBoard) {
  for (const char* const name : {"rpi4_dxq608", "pine64_ls055"}) {
    const std::string path = std::string(PLUMBLINE_SOURCE_DIR "/board/") + name + ".toml";
    std::ifstream file(path);
    int keys = 0;
    for (std::string line; std::getline(file, line);) {
      if (line.find(" = ") == std::string::npos || line.starts_with('#')) continue;
      ++keys;
      EXPECT_NE(line.find(" # "), std::string::npos) << path << ": " << line;
    }
    EXPECT_GT(keys, 50);
    const auto board = read_board_file(path);
    ASSERT_TRUE(board) << board.error().message();
    EXPECT_TRUE(missing_tables(board->machine->wiring).empty()) << path << " is not wired";
  }
}

TEST(BoardFile, AllowsExactlyTheRange) {
  EXPECT_TRUE(parse_board_file(good_with("columns = 1440", "columns = 1"), "b.toml"));
  EXPECT_TRUE(parse_board_file(good_with("columns = 1440", "columns = 16384"), "b.toml"));
  EXPECT_EQ(refusal(good_with("columns = 1440", "columns = 0")),
            "b.toml:4: [panel] columns: found an integer 0, allowed is an integer from 1 to 16384 pixels");
  EXPECT_THAT(refusal(good_with("columns = 1440", "columns = 16385")), HasSubstr("found an integer 16385"));
  EXPECT_THAT(refusal(good_with("columns = 1440", "columns = -1440")), HasSubstr("found an integer -1440"));
  EXPECT_THAT(refusal(good_with("columns = 1440", "columns = 9223372036854775807")), HasSubstr("9223372036854775807"));
  EXPECT_EQ(refusal(good_with("= 0.04725", "= 0.0047")),
            "b.toml:6: [panel] pixel_pitch_x_mm: found a float 0.0047, allowed is a number from 0.005 to 1 mm");
}

TEST(BoardFile, RefusesNanAndInfinity) {
  for (const char* value : {"nan", "inf", "-inf"}) {
    EXPECT_THAT(
        refusal(good_with("travel_mm = 160", std::string{"travel_mm = "} + value)),
        AllOf(StartsWith("b.toml:9: [z_stage] travel_mm: found a float "), HasSubstr("a number from 1 to 2000 mm")));
  }
}

TEST(BoardFile, RefusesAWrongType) {
  EXPECT_EQ(refusal(good_with("columns = 1440", "columns = '1440'")),
            "b.toml:4: [panel] columns: found a string '1440', allowed is an integer from 1 to 16384 pixels");
  EXPECT_THAT(refusal(good_with("columns = 1440", "columns = 1440.0")), HasSubstr("found a float 1440,"));
  EXPECT_THAT(refusal(good_with("travel_mm = 160", "travel_mm = true")), HasSubstr("found a boolean true,"));
  EXPECT_THAT(refusal(good_with("travel_mm = 160", "travel_mm = [160]")), HasSubstr("found an array,"));
  EXPECT_THAT(refusal(good_with("travel_mm = 160", "travel_mm = 1979-05-27")), HasSubstr("found a date 1979-05-27,"));
  EXPECT_THAT(refusal(good_with("travel_mm = 160", "travel_mm = {mm = 160}")), HasSubstr("found a table,"));
  EXPECT_THAT(refusal(good_with("\"test\"", "7")),
              StartsWith("b.toml:2: [printer] name: found an integer 7, allowed is a string"));
}

TEST(BoardFile, RefusesNamesThatAreEmptyTooLongOrNeedQuoting) {
  EXPECT_THAT(refusal(good_with("\"test\"", "''")), HasSubstr("allowed is a string of 1 to 63 letters, digits"));
  EXPECT_THAT(refusal(good_with("test", std::string(64, 'a'))), HasSubstr("aaa..."));
  EXPECT_TRUE(parse_board_file(good_with("test", std::string(63, 'a')), "b.toml"));
  EXPECT_THAT(refusal(good_with("test", "a/b")), HasSubstr("'a/b'"));
}

TEST(BoardFile, RefusesAnUnknownKeyAndNamesTheNearest) {
  EXPECT_EQ(refusal(good_with("columns = 1440", "colums = 1440")),
            "b.toml:4: [panel] colums: unknown key; the nearest known one is columns. Allowed are columns, rows, "
            "pixel_pitch_x_mm, pixel_pitch_y_mm, packing, mirror, rotation_deg, refresh_delay_ms, grey_levels, "
            "grey_gamma, grey_exposures, lamp_map");
  EXPECT_THAT(refusal(good_with("pixel_pitch_y_mm", "pixel_pitch_mm_y")), HasSubstr("is pixel_pitch_"));
  EXPECT_THAT(refusal(good_with("rows = 2560", "rows = 2560\nflip = true")),
              StartsWith("b.toml:6: [panel] flip: unknown key;"));
}

TEST(BoardFile, ReportsTheUnknownKeyThatComesFirstInTheFile) {
  EXPECT_THAT(refusal(good_with("columns = 1440", "zolumns = 1440") + "arena_mb = 1\n"), StartsWith("b.toml:4: "));
  EXPECT_THAT(refusal("[zzz]\n" + std::string{kGood} + "arena_mb = 1\n"), StartsWith("b.toml:1: "));
}

TEST(BoardFile, RefusesAnUnknownTableAndNamesTheNearest) {
  EXPECT_EQ(
      refusal(good_with("[z_stage]", "[zstage]")),
      "b.toml:8: zstage: unknown; the nearest table is [z_stage]. Allowed are printer, panel, "
      "z_stage, lamp, cover, temperatures, tank, print, memory, display, screen, lamp_line, cover_line, step_line, "
      "direction_line, enable_line, end_stop_line, start_button, pause_button, cancel_button, ready_light, "
      "printing_light, attention_light, fault_light, buzzer, lamp_sensor, resin_sensor, board_sensor, lamp_fan, "
      "chamber_fan, stick, watchdog");
}

TEST(BoardFile, SaysInWhichTableAKeyBelongs) {
  EXPECT_EQ(refusal(good_with("[memory]\n", "")), "b.toml:12: [print] arena_mib: this key belongs in [memory]");
  EXPECT_EQ(refusal("rows = 3\n" + std::string{kGood}), "b.toml:1: rows: this key belongs in [panel]");
}

TEST(BoardFile, RefusesAMissingKey) {
  EXPECT_EQ(refusal(good_with("rows = 2560\n", "")),
            "b.toml:3: [panel] rows: missing; allowed is an integer from 1 to 16384 pixels");
}

TEST(BoardFile, RefusesAMissingTable) {
  EXPECT_EQ(
      refusal(good_with("[memory]\narena_mib = 96\n", "")),
      "b.toml:11: [memory] arena_mib: missing, the file has no [memory]; allowed is an integer from 8 to 65536 MiB");
  EXPECT_THAT(refusal(""), StartsWith("b.toml:1: [printer] name: missing"));
}

TEST(BoardFile, RefusesAValueInPlaceOfATable) {
  EXPECT_EQ(refusal("memory = 96\n" + good_with("[memory]\narena_mib = 96\n", "")),
            "b.toml:1: memory: found an integer 96, allowed is a table [memory]");
  EXPECT_THAT(refusal(good_with("[memory]", "[[memory]]")),
              HasSubstr("memory: found an array, allowed is a table [memory]"));
}

TEST(BoardFile, RefusesTextThatIsNotToml) {
  EXPECT_THAT(refusal(good_with("columns = 1440", "columns 1440"), ErrorCode::kMalformed),
              StartsWith("b.toml:4: not TOML at column "));
  EXPECT_THAT(refusal(good_with("rows", "columns"), ErrorCode::kMalformed), StartsWith("b.toml:5: not TOML"));
  EXPECT_THAT(refusal("ply\nformat ascii 1.0\n", ErrorCode::kMalformed), StartsWith("b.toml:1: not TOML"));
  EXPECT_THAT(refusal(std::string("\xFF\xFE[\0", 4), ErrorCode::kMalformed), StartsWith("b.toml:1: not TOML"));
  EXPECT_THAT(refusal("a = " + std::string(10000, '['), ErrorCode::kMalformed), StartsWith("b.toml:1: not TOML"));
}

TEST(BoardFile, ReadsTheMachine) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml");
  ASSERT_TRUE(board) << board.error().message();
  const auto machine = machine_of(*board, "sim2k.toml");
  ASSERT_TRUE(machine) << machine.error().message();
  EXPECT_FALSE(machine->panel.rgb);
  EXPECT_EQ(machine->panel.mirror, PanelLayout::Mirror::kX);
  EXPECT_EQ(machine->panel.rotation_deg, 0U);
  EXPECT_EQ(machine->panel.grey.levels, 256U);
  EXPECT_EQ(machine->panel.grey.gamma, 1);
  EXPECT_DOUBLE_EQ(machine->step_mm(), 0.00125);
  EXPECT_EQ(machine->power_mw_cm2, 3.5);
  EXPECT_TRUE(machine->has_cover_switch);
  EXPECT_EQ(machine->profile, "standard");
}

TEST(BoardFile, ServesOnlyForSlicingWithoutTheMachinesKeys) {
  const auto board = parse_board_file(kGood, "b.toml");
  ASSERT_TRUE(board);
  EXPECT_FALSE(board->machine);
  const auto machine = machine_of(*board, "b.toml");
  ASSERT_FALSE(machine);
  EXPECT_THAT(machine.error().message(), AllOf(StartsWith("b.toml: describes a panel"), HasSubstr("[lamp]")));
}

TEST(BoardFile, NeedsAllOfTheMachinesKeysOrNone) {
  EXPECT_EQ(refusal(good_with("rows = 2560", "rows = 2560\nmirror = 'x'")),
            "b.toml:1: [printer] simulated: missing; allowed is true or false");
}

std::string sim2k_with(const std::string& from, const std::string& to) {
  auto text = read_settings_text(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml", "a board file").value();
  const auto at = text.find(from);
  if (at == std::string::npos) ADD_FAILURE() << from << " is not in sim2k.toml";
  return text.replace(at, from.size(), to);
}

TEST(BoardFile, ShowsNoGreyUnlessItSaysSo) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/mono2k.toml");
  ASSERT_TRUE(board) << board.error().message();
  EXPECT_FALSE(board->machine->panel.grey.has_grey());
  const auto sixteen = parse_board_file(sim2k_with("grey_levels = 256", "grey_levels = 16"), "b.toml");
  ASSERT_TRUE(sixteen) << sixteen.error().message();
  EXPECT_TRUE(sixteen->machine->panel.grey.has_grey());
  EXPECT_THAT(refusal(sim2k_with("grey_levels = 256", "grey_levels = 1")), HasSubstr("found an integer 1, allowed is"));
  EXPECT_THAT(refusal(sim2k_with("grey_gamma = 1.0", "grey_gamma = 0")), HasSubstr("[panel] grey_gamma: found"));
}

TEST(BoardFile, ShowsGreyByExposuresOnAPanelOfBlackAndWhiteOnly) {
  const auto text_of = [](const std::string& levels, const std::string& exposures) {
    const std::string key = "grey_exposures = ";
    std::string text = sim2k_with("grey_levels = 256", "grey_levels = " + levels);
    return text.replace(text.find(key + "0"), key.size() + 1, key + exposures);
  };
  const auto board = parse_board_file(text_of("2", "3"), "b.toml");
  ASSERT_TRUE(board) << board.error().message();
  const GreyScale& grey = board->machine->panel.grey;
  EXPECT_TRUE(grey.has_grey() && !grey.has_levels() && grey.exposures == 3);
  EXPECT_THAT(refusal(text_of("4", "3")),
              HasSubstr("[panel] grey_exposures: found an integer 3, allowed is 0 with grey_levels above 2"));
  EXPECT_THAT(refusal(text_of("2", "5")), HasSubstr("found an integer 5, allowed"));
}

TEST(BoardFile, HasALampMapOfAPanelThatShowsGrey) {
  const auto with = [](const std::string& map, const std::string& levels = "256") {
    return sim2k_with("grey_levels = 256", "lamp_map = " + map + "\ngrey_levels = " + levels);
  };
  EXPECT_FALSE(parse_board_file(with("[[1]]"), "b.toml")->machine->panel.lamp.spread() > 1);
  const auto board = parse_board_file(with("[[3, 3.3, 4],\n [2.5, 3, 3.5]]"), "b.toml");
  ASSERT_TRUE(board) << board.error().message();
  const LampMap& map = board->machine->panel.lamp;
  EXPECT_EQ(map.columns, 3U);
  EXPECT_EQ(map.rows, 2U);
  EXPECT_THAT(map.all(), testing::ElementsAre(3, 3.3, 4, 2.5, 3, 3.5));
  std::string row = "[1", rows;
  for (int i = 1; i < 16; ++i) row += ", 1";
  row += "]";
  for (int i = 0; i < 16; ++i) rows += (i == 0 ? "[" : ", ") + row;
  EXPECT_TRUE(parse_board_file(with(rows + "]"), "b.toml"));
  for (const std::string& wrong : std::vector<std::string>{
           "[]", "[[]]", "3", "[1, 2]", "[[1, 2], [1]]", "[[1], [1, 2]]", "[[0]]", "[[-1]]", "[[nan]]", "[[inf]]",
           "[[\"1\"]]", rows + ", " + row + "]", "[" + row.substr(0, 47) + ", 1]]"}) {
    EXPECT_THAT(refusal(with(wrong)), HasSubstr("[panel] lamp_map: found ")) << wrong;
    EXPECT_THAT(refusal(with(wrong)), HasSubstr("allowed is an array of 1 to 16 rows, each an array of as many"));
  }
  EXPECT_THAT(refusal(with("[[1, 2.5]]")),
              HasSubstr("lamp_map: found an array, whose brightest place is 2.5 times the"));
  EXPECT_THAT(refusal(with("[[1, 1.2]]", "2")), HasSubstr("allowed is none with grey_levels = 2: a panel that shows"));
}

TEST(BoardFile, RefusesWordsAndNumbersThatAreNotAChoice) {
  EXPECT_THAT(refusal(sim2k_with("mirror = \"x\"", "mirror = \"z\"")),
              HasSubstr("[panel] mirror: found a string 'z', allowed is one of the strings none, x or y"));
  EXPECT_THAT(refusal(sim2k_with("rotation_deg = 0", "rotation_deg = 45")),
              HasSubstr("found an integer 45, allowed is one of the integers 0, 90, 180 or 270 degrees"));
  EXPECT_THAT(refusal(sim2k_with("microsteps = 16", "microsteps = 12")), HasSubstr("found an integer 12"));
  EXPECT_THAT(refusal(sim2k_with("switch = true", "switch = 1")), HasSubstr("allowed is true or false"));
}

TEST(BoardFile, RefusesKeysThatContradictEachOther) {
  EXPECT_THAT(refusal(sim2k_with("lamp_resume_c = 50.0", "lamp_resume_c = 65.0")),
              HasSubstr("lamp_resume_c: found a float 65, allowed is less than lamp_max_c"));
  EXPECT_THAT(refusal(sim2k_with("resin_min_c = 18.0", "resin_min_c = 41.0")), HasSubstr("less than resin_max_c"));
  EXPECT_THAT(refusal(sim2k_with("homing_speed_mm_min = 60.0", "homing_speed_mm_min = 301.0")),
              HasSubstr("at most max_speed_mm_min"));
  EXPECT_THAT(refusal(sim2k_with("end_stop_height_mm = 175.0", "end_stop_height_mm = 160.5")),
              HasSubstr("at least travel_mm + 1"));
  EXPECT_THAT(refusal(good_with("columns = 1440", "columns = 1441\npacking = 'rgb'")), HasSubstr("missing"));
  auto rgb = sim2k_with("packing = \"none\"", "packing = \"rgb\"");
  EXPECT_TRUE(parse_board_file(rgb, "b.toml"));
  rgb.replace(rgb.find("columns = 1440"), 14, "columns = 1441");
  EXPECT_THAT(refusal(rgb), HasSubstr("packing: found a string 'rgb', allowed is \"none\""));
}

std::string rig_with(const std::string& from, const std::string& to) {
  auto text = read_settings_text(PLUMBLINE_SOURCE_DIR "/board/rig.toml", "a board file").value();
  const auto at = text.find(from);
  if (at == std::string::npos) ADD_FAILURE() << from << " is not in rig.toml";
  return text.replace(at, from.size(), to);
}

TEST(BoardFile, ReadsTheWiring) {
  const auto board = parse_board_file(
      rig_with("offset = 5\nactive = \"high\"", "offset = 5\nactive = \"low\"\nbias = \"pull-up\""), "b.toml");
  ASSERT_TRUE(board) << board.error().message();
  const Wiring& wiring = board->machine->wiring;
  EXPECT_EQ(wiring.display.connector, "Virtual-1");
  EXPECT_EQ(wiring.cover.chip, "9030000.pl061");
  EXPECT_EQ(wiring.cover.offset, 5U);
  EXPECT_TRUE(wiring.cover.active_low);
  EXPECT_EQ(wiring.cover.bias, LineBias::kPullUp);
  EXPECT_EQ(wiring.thermals.sensors[1].file, "/run/rig/resin_temperature");
  EXPECT_FALSE(wiring.pause_button.given());
  EXPECT_EQ(wiring.watchdog.device, "/dev/watchdog0");
  EXPECT_EQ(wiring.watchdog.timeout_s, 10U);
  EXPECT_TRUE(missing_tables(wiring).empty());
}

TEST(BoardFile, ListsMissingWiringTables) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/mono2k.toml");
  ASSERT_TRUE(board);
  EXPECT_THAT(missing_tables(board->machine->wiring),
              ::testing::UnorderedElementsAre("display", "lamp_line", "step_line", "direction_line", "end_stop_line",
                                              "lamp_sensor", "resin_sensor", "board_sensor"));
}

TEST(BoardFile, RefusesALineGivenTwiceOrIncompletely) {
  EXPECT_THAT(
      refusal(rig_with("[lamp_line]", "[lamp_line]\nline = \"LAMP\"")),
      HasSubstr("[lamp_line] line: found a string 'LAMP', but a line is given either by line or by chip and offset"));
  EXPECT_THAT(refusal(rig_with("offset = 1\n", "")), HasSubstr("but chip and offset go together"));
  EXPECT_THAT(refusal(rig_with("[lamp_sensor]", "[lamp_sensor]\nhwmon = \"lm75\"")),
              HasSubstr("a sensor is given by exactly one of hwmon, thermal_zone and file"));
  EXPECT_THAT(refusal(rig_with("[lamp_sensor]", "[lamp_fan]\nchannel = 1\n[lamp_sensor]")),
              HasSubstr("a fan is given either by hwmon or by pwm_chip"));
  EXPECT_THAT(refusal(rig_with("device = \"/dev/watchdog0\"", "")), HasSubstr("a watchdog is given by device"));
  EXPECT_THAT(refusal(rig_with("timeout_s = 10", "timeout_s = 1")), HasSubstr("an integer from 2 to 60"));
  EXPECT_THAT(refusal(rig_with("offset = 1\n", "offset = 1024\n")), HasSubstr("an integer from 0 to 1023"));
}

TEST(BoardReadme, ExplainsEveryTableAndKeyOfTheWiring) {
  const auto page = read_settings_text(PLUMBLINE_SOURCE_DIR "/board/README.md", "a page").value();
  Wiring wiring;
  std::vector<SettingRule> rules;
  add_wiring_rules(rules, wiring);
  for (const auto& rule : rules) {
    EXPECT_THAT(page, HasSubstr(std::string("`[").append(rule.table).append("]`")));
    EXPECT_THAT(page, HasSubstr(std::string("`").append(rule.key).append("`")));
  }
  EXPECT_GE(rules.size(), 80U);
}

TEST(BoardFile, RefusesAFileOfAnotherKindBySize) {
  EXPECT_THAT(refusal(std::string(kMaxSettingsFileBytes + 1, '\n'), ErrorCode::kMalformed),
              HasSubstr("larger than 65536 bytes"));
}

TEST(BoardFile, KeepsControlCharactersOutOfMessages) {
  EXPECT_THAT(refusal(good_with("columns = 1440", "\"\\u001B[31m\" = 1440")),
              AllOf(HasSubstr("\\x1b[31m"), Not(HasSubstr("\x1B"))));
}

TEST(BoardFile, NamesAFileThatCannotBeOpenedOrRead) {
  const auto missing = read_board_file("/nowhere/b.toml");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code(), ErrorCode::kCannotOpen);
  EXPECT_THAT(missing.error().message(), StartsWith("/nowhere/b.toml: no such board file. Check the path, or name"));

  const auto folder = read_board_file(PLUMBLINE_SOURCE_DIR "/board");
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().code(), ErrorCode::kCannotRead);
}

TEST(BoardFile, ShowsTheReasonOfAParseErrorInWholeWords) {
  const std::string said = refusal("a = " + std::string(10000, '['), ErrorCode::kMalformed);
  EXPECT_THAT(said, HasSubstr("exceeded maximum nested value depth"));
  // Long paths leave room for the reason.
  const auto far = parse_board_file("x", std::string(1000, 'p'));
  ASSERT_FALSE(far);
  EXPECT_THAT(far.error().message(), HasSubstr("...:1: not TOML at column 2: "));
}

TEST(BoardFile, IsReadFromAFile) {
  const std::string path = ::testing::TempDir() + "plumbline_board_file_test.toml";
  std::ofstream{path} << good_with("rows = 2560", "rows = 'many'");
  const auto board = read_board_file(path);
  std::filesystem::remove(path);
  ASSERT_FALSE(board);
  EXPECT_THAT(board.error().message(),
              HasSubstr("plumbline_board_file_test.toml:5: [panel] rows: found a string 'many'"));
}

}  // namespace
}  // namespace plumbline::firmware
