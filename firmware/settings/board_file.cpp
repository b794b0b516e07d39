#include "firmware/settings/board_file.hpp"

#include <array>
#include <utility>
#include <vector>

#include "firmware/settings/setting_words.hpp"
#include "firmware/settings/settings_folders.hpp"
#include "firmware/settings/wiring_file.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::firmware::inline settings {
namespace {

constexpr double kMaxSide = PrintGrid::kMaxSide;
constexpr std::array<std::string_view, 2> kPackings = {"none", "rgb"};    // by PanelLayout::rgb
constexpr std::array<std::string_view, 3> kMirrors = {"none", "x", "y"};  // by PanelLayout::Mirror
constexpr std::array<std::string_view, 3> kStarts = {"on_request", "on_stick", "after_preview"};  // by StartChoice
constexpr std::array<std::string_view, 3> kPages = {"off", "local", "network"};                   // by PageChoice
constexpr std::array<std::uint32_t, 9> kMicrosteps = {1, 2, 4, 8, 16, 32, 64, 128, 256};

}  // namespace

std::vector<SettingRule> board_rules(BoardFile& board, MachineFile& machine) {
  constexpr auto kMachine = Presence::kAllOrNone;
  std::vector<SettingRule> rules = {
      {"printer", "name", TextSetting{&board.name}, 1, 63},
      {"printer", "simulated", &machine.simulated, 0, 0, "", kMachine},
      {"printer", "state_socket", TextSetting{&machine.state_socket, TextKind::kPath}, 1, 255, "", Presence::kOptional},
      {"printer", "language", choice(kLanguageCodes, machine.language), 0, 0, "", Presence::kOptional},
      {"printer", "page", choice(kPages, machine.page), 0, 0, "", Presence::kOptional},
      {"printer", "page_port", &machine.page_port, 1024, 65535, "", Presence::kOptional},
      {"printer", "page_host", TextSetting{&machine.page_host}, 1, 253, "", Presence::kOptional},
      {"printer", "upload_mib", &machine.upload_mib, 0, 4096, " MiB", Presence::kOptional},
      {"printer", "relative_correction_x", &board.relative_correction[0], kLeastCorrection, kMostCorrection, "",
       Presence::kOptional},
      {"printer", "relative_correction_y", &board.relative_correction[1], kLeastCorrection, kMostCorrection, "",
       Presence::kOptional},
      {"printer", "relative_correction_z", &board.relative_correction[2], kLeastCorrection, kMostCorrection, "",
       Presence::kOptional},
      {"panel", "columns", &board.columns, 1, kMaxSide, " pixels"},
      {"panel", "rows", &board.rows, 1, kMaxSide, " pixels"},
      {"panel", "pixel_pitch_x_mm", &board.pixel_pitch_x_mm, 0.005, 1, " mm"},
      {"panel", "pixel_pitch_y_mm", &board.pixel_pitch_y_mm, 0.005, 1, " mm"},
      {"panel", "packing", choice(kPackings, machine.panel.rgb), 0, 0, "", kMachine},
      {"panel", "mirror", choice(kMirrors, machine.panel.mirror), 0, 0, "", kMachine},
      {"panel", "rotation_deg", NumberChoiceSetting{kRotations, &machine.panel.rotation_deg}, 0, 0, " degrees",
       kMachine},
      {"panel", "refresh_delay_ms", &machine.refresh_delay_ms, 0, 1000, " ms", kMachine},
      {"panel", "grey_levels", &machine.panel.grey.levels, 2, 256, "", Presence::kOptional},
      {"panel", "grey_gamma", &machine.panel.grey.gamma, 0.2, 5, "", Presence::kOptional},
      {"panel", "grey_exposures", &machine.panel.grey.exposures, 0, GreyScale::kMostExposures, "", Presence::kOptional},
      {"panel", "lamp_map", &machine.panel.lamp, 0.001, 1e6, "", Presence::kOptional},
      {"z_stage", "travel_mm", &board.travel_mm, 1, 2000, " mm"},
      {"z_stage", "rotation_distance_mm", &machine.rotation_distance_mm, 0.1, 100, " mm", kMachine},
      {"z_stage", "full_steps_per_rotation", &machine.full_steps_per_rotation, 20, 1000, " steps", kMachine},
      {"z_stage", "microsteps", NumberChoiceSetting{kMicrosteps, &machine.microsteps}, 0, 0, "", kMachine},
      {"z_stage", "max_speed_mm_min", &machine.max_speed_mm_min, 1, 6000, " mm/min", kMachine},
      {"z_stage", "max_acceleration_mm_s2", &machine.max_acceleration_mm_s2, 1, 10000, " mm/s2", kMachine},
      {"z_stage", "homing_speed_mm_min", &machine.homing_speed_mm_min, 1, 600, " mm/min", kMachine},
      {"z_stage", "end_stop_height_mm", &machine.end_stop_height_mm, 1, 2100, " mm", kMachine},
      {"lamp", "power_mw_cm2", &machine.power_mw_cm2, 0.1, 100, " mW/cm2", kMachine},
      {"lamp", "max_exposure_s", &machine.max_exposure_s, 0.1, 300, " s", kMachine},
      {"lamp", "max_light_per_minute_s", &machine.max_light_per_minute_s, 0.1, 60, " s", kMachine},
      {"lamp", "warm_up_ms", &machine.warm_up_ms, 0, 1000, " ms", kMachine},
      {"cover", "switch", &machine.has_cover_switch, 0, 0, "", kMachine},
      {"temperatures", "lamp_resume_c", &machine.lamp_resume_c, 20, 100, " C", kMachine},
      {"temperatures", "lamp_max_c", &machine.lamp_max_c, 30, 120, " C", kMachine},
      {"temperatures", "resin_min_c", &machine.resin_min_c, 0, 60, " C", kMachine},
      {"temperatures", "resin_max_c", &machine.resin_max_c, 0, 80, " C", kMachine},
      {"temperatures", "board_max_c", &machine.board_max_c, 40, 120, " C", Presence::kOptional},
      {"tank", "volume_ml", &machine.tank_volume_ml, 1, 20000, " ml", kMachine},
      {"print", "layer_height_mm", &board.layer_height_mm, 0.005, 1, " mm"},
      {"print", "profile", TextSetting{&machine.profile}, 1, 63, "", kMachine},
      {"print", "start", choice(kStarts, machine.start), 0, 0, "", Presence::kOptional},
      {"memory", "arena_mib", &board.arena_mib, 8, 65536, " MiB"},
  };
  add_wiring_rules(rules, machine.wiring);
  return rules;
}

std::string check_board_key(const SettingRule& rule, const BoardFile& board, MachineFile& machine) {
  machine.panel.columns = board.columns;
  machine.panel.rows = board.rows;
  if (rule.key == "grey_exposures" && machine.panel.grey.exposures > 0 && machine.panel.grey.has_levels()) {
    return "allowed is 0 with grey_levels above 2: the panel shows grey itself, in one exposure";
  }
  if (rule.key == "lamp_map" && machine.panel.lamp.known()) {
    if (!machine.panel.grey.has_levels()) {
      return "allowed is none with grey_levels = 2: a panel that shows black and white can't dim a place. Leave it out";
    }
    if (const double spread = machine.panel.lamp.spread(); spread > LampMap::kMostSpread) {
      return "whose brightest place is " + number(spread) +
             " times the darkest, allowed are 2 times: repair the lamp, or measure again";
    }
  }
  if (rule.key == "lamp_resume_c" && machine.lamp_resume_c >= machine.lamp_max_c) {
    return "allowed is less than lamp_max_c";
  }
  if (rule.key == "resin_min_c" && machine.resin_min_c >= machine.resin_max_c) {
    return "allowed is less than resin_max_c";
  }
  if (rule.key == "homing_speed_mm_min" && machine.homing_speed_mm_min > machine.max_speed_mm_min) {
    return "allowed is at most max_speed_mm_min";
  }
  if (rule.key == "end_stop_height_mm" && machine.end_stop_height_mm < board.travel_mm + kEndStopClearanceMm) {
    return "allowed is at least travel_mm + 1: the tallest print must not reach the end stop";
  }
  if (rule.key == "packing" && !machine.panel.check()) {
    const bool sideways = machine.panel.rotation_deg % 180 != 0;
    return std::string("allowed is \"none\": with this rotation_deg, ") + (sideways ? "rows" : "columns") +
           " must be a multiple of 3 to be packed";
  }
  return check_wiring(rule, machine.wiring);
}

Expected<BoardFile> parse_board_file(std::string_view text, std::string_view path) {
  BoardFile board;
  MachineFile machine;
  bool has_machine = false;
  const auto rules = board_rules(board, machine);
  const auto check_key = [&](const SettingRule& rule) {
    return has_machine ? check_board_key(rule, board, machine) : std::string();
  };
  PLUMBLINE_TRY(parse_settings(text, path, {"a board file", rules, &has_machine, check_key}));
  if (has_machine) board.machine = std::move(machine);
  return board;
}

Expected<BoardFile> read_board_file(const std::string& name_or_path) {
  const auto path = find_board_file(name_or_path);
  PLUMBLINE_TRY(path);
  const auto text = read_settings_text(*path, "a board file");
  PLUMBLINE_TRY(text);
  auto board = parse_board_file(*text, *path);
  PLUMBLINE_TRY(board);
  PLUMBLINE_TRY(check_file_name(*path, "[printer] name", board->name));
  board->path = *path;
  return board;
}

Expected<MachineFile> machine_of(const BoardFile& board, std::string_view path) {
  if (board.machine) return *board.machine;
  return fail(
      ErrorCode::kBadSetting,
      "%.*s: describes a panel but no machine. To print, add the keys that board/README.md marks with *: the rest "
      "of [panel] and [z_stage], and [lamp], [cover], [temperatures] and [tank]",
      static_cast<int>(path.size()), path.data());
}

PrinterVolume printer_volume(const BoardFile& board) {
  return {.columns = board.columns,
          .rows = board.rows,
          .pitch_x_mm = static_cast<float>(board.pixel_pitch_x_mm),
          .pitch_y_mm = static_cast<float>(board.pixel_pitch_y_mm),
          .travel_mm = static_cast<float>(board.travel_mm)};
}

}  // namespace plumbline::firmware::inline settings
