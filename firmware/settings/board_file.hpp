#pragma once
/// Reads the file that describes a printer, board/*.toml. board/README.md explains each key.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/messages/catalogue.hpp"
#include "firmware/settings/settings_file.hpp"
#include "hal/panel_layout.hpp"
#include "hal/wiring.hpp"
#include "slicer/core/error.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline::firmware::inline settings {

/// mm between the highest position of a move and the end stop, so that no move presses it. Homing finds the end stop to within a
/// microstep, so any clearance above the switch's own travel would do.
inline constexpr double kEndStopClearanceMm = 1;

/// What begins a print.
enum class StartChoice : std::uint8_t {
  kOnRequest,     ///< somebody presses start
  kOnStick,       ///< a stick is in: for test rigs
  kAfterPreview,  ///< somebody presses start for the scan, and again when they have seen what was sliced
};

/// Who may reach the printer's page.
enum class PageChoice : std::uint8_t {
  kOff,      ///< nobody: there is none
  kLocal,    ///< this machine
  kNetwork,  ///< whoever reaches this machine; commands need a code from the printer's screen
};

/// The part of a board file that printing needs and slicing does not.
struct MachineFile {
  bool simulated = false;                       ///< [printer] simulate it: no such machine exists
  std::string state_socket;                     ///< [printer] path of the daemon's state socket; empty: the default
  Language language = Language::kEnglish;       ///< [printer] of its screen
  PageChoice page = PageChoice::kOff;           ///< [printer]
  std::uint32_t page_port = 8080;               ///< [printer] TCP
  std::string page_host;                        ///< [printer] a further name that browsers know this machine by
  std::uint32_t upload_mib = 256;               ///< [printer] largest scan that is taken through the page; 0: none
  PanelLayout panel;                            ///< [panel]
  double refresh_delay_ms = 0;                  ///< [panel] from the end of the scan-out until the pixels have settled
  double rotation_distance_mm = 0;              ///< [z_stage] travel for one turn of the motor
  std::uint32_t full_steps_per_rotation = 0;    ///< [z_stage] of the motor
  std::uint32_t microsteps = 0;                 ///< [z_stage] pulses for a full step: a power of two up to 256
  double max_speed_mm_min = 0;                  ///< [z_stage]
  double max_acceleration_mm_s2 = 0;            ///< [z_stage]
  double homing_speed_mm_min = 0;               ///< [z_stage] of the second, slow approach to the end stop
  double end_stop_height_mm = 0;                ///< [z_stage] height of the plate where the end stop closes
  double power_mw_cm2 = 0;                      ///< [lamp] irradiance at the film
  double max_exposure_s = 0;                    ///< [lamp] longest single exposure
  double max_light_per_minute_s = 0;            ///< [lamp] most light in any minute
  double warm_up_ms = 0;                        ///< [lamp] from off to full power, linear
  bool has_cover_switch = false;                ///< [cover]
  double lamp_resume_c = 0;                     ///< [temperatures] a print paused to cool the lamp resumes below this
  double lamp_max_c = 0;                        ///< [temperatures] the print pauses above this
  double resin_min_c = 0;                       ///< [temperatures]
  double resin_max_c = 0;                       ///< [temperatures]
  double board_max_c = 85;                      ///< [temperatures] of the processor: the print pauses above this
  double tank_volume_ml = 0;                    ///< [tank] resin in a full tank
  std::string profile;                          ///< [print] file in board/profiles, unless the user names another
  StartChoice start = StartChoice::kOnRequest;  ///< [print]
  Wiring wiring;                                ///< [display], [lamp_line], ...: empty for a simulated printer

  /// mm of travel for one pulse of the driver.
  double step_mm() const { return rotation_distance_mm / (full_steps_per_rotation * microsteps); }
};

/// A printer's board file. Every number is in the range that board/README.md gives.
struct BoardFile {
  std::string path;             ///< that it was read from; empty if it came from memory
  std::string name;             ///< [printer]
  std::uint32_t columns = 0;    ///< [panel] pixels along x
  std::uint32_t rows = 0;       ///< [panel] pixels along y
  double pixel_pitch_x_mm = 0;  ///< [panel]
  double pixel_pitch_y_mm = 0;  ///< [panel]
  double travel_mm = 0;         ///< [z_stage] height of the tallest print
  /// [printer] by how much larger than the object masks are, along x, y and z; the profile's material_correction multiplies it
  std::array<double, 3> relative_correction = {1, 1, 1};
  double layer_height_mm = 0;   ///< [print]
  std::uint32_t arena_mib = 0;  ///< [memory]
  /// Absent if the file describes only what slicing needs: it must have all of these keys or none.
  std::optional<MachineFile> machine;
};

/// Range of relative_correction and material_correction.
inline constexpr double kLeastCorrection = 0.9, kMostCorrection = 1.1;

/// Reads a board file, which must be named after its printer.
/// @param name_or_path  see find_board_file()
/// @retval the errors of find_board_file(), check_file_name() and read_settings_file()
[[nodiscard]] Expected<BoardFile> read_board_file(const std::string& name_or_path);

/// The same from text in memory.
/// @param path  for messages only
[[nodiscard]] Expected<BoardFile> parse_board_file(std::string_view text, std::string_view path);

/// The rules of a board file's keys, bound to where their values are, in the order of board/README.md.
std::vector<SettingRule> board_rules(BoardFile& board, MachineFile& machine);

/// What is wrong with the value of one key given the others: "allowed is less than lamp_max_c". Empty: nothing.
std::string check_board_key(const SettingRule& rule, const BoardFile& board, MachineFile& machine);

/// @retval ErrorCode::kBadSetting  the file lacks the keys that printing needs
[[nodiscard]] Expected<MachineFile> machine_of(const BoardFile& board, std::string_view path);

/// The build volume.
PrinterVolume printer_volume(const BoardFile& board);

}  // namespace plumbline::firmware::inline settings
