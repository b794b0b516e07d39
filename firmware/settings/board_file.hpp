#pragma once
/// The file that describes a printer: board/*.toml, each key explained in board/README.md.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/settings/settings_file.hpp"
#include "firmware/settings/wiring_file.hpp"
#include "slicer/core/error.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline {

/// How the pixels of the panel go over its cable.
enum class PixelPacking : std::uint8_t {
  kNone,  ///< one pixel of the picture for each
  kRgb,   ///< three neighbours of a row as red, green and blue of one pixel: monochrome panels made from colour ones
};
enum class PanelMirror : std::uint8_t { kNone, kX, kY };  ///< both together are a rotation by 180 degrees

/// mm between the highest point of moves and the end stop.
inline constexpr double kEndStopClearanceMm = 1;

/// What a printer needs to move and light, beyond what the slicer asks.
struct MachineFile {
  bool simulated = false;                      ///< [printer] there is no such machine
  PixelPacking packing = PixelPacking::kNone;  ///< [panel]
  PanelMirror mirror = PanelMirror::kNone;     ///< [panel] after the rotation
  std::uint32_t rotation_deg = 0;              ///< [panel] 0, 90, 180, 270, counter-clockwise
  double refresh_delay_ms = 0;                 ///< [panel] from the end of the scan-out to a still picture
  double rotation_distance_mm = 0;             ///< [z_stage] travel for a whole turn of the motor
  std::uint32_t full_steps_per_rotation = 0;   ///< [z_stage] of the motor
  std::uint32_t microsteps = 0;                ///< [z_stage] a full step: a power of two to 256
  double max_speed_mm_min = 0;                 ///< [z_stage]
  double max_acceleration_mm_s2 = 0;           ///< [z_stage]
  double homing_speed_mm_min = 0;              ///< [z_stage] second, slow approach of the end stop
  double end_stop_height_mm = 0;               ///< [z_stage] of the plate above the film where the end stop closes
  double power_mw_cm2 = 0;                     ///< [lamp] irradiance at the film
  double max_exposure_s = 0;                   ///< [lamp] longest time on in one go
  double warm_up_ms = 0;                       ///< [lamp] from off to full power, linear
  bool has_cover_switch = false;               ///< [cover]
  double lamp_resume_c = 0;                    ///< [temperatures] below it a print that had to cool goes on
  double lamp_max_c = 0;                       ///< [temperatures] above it the lamp stays off
  double resin_min_c = 0;                      ///< [temperatures]
  double resin_max_c = 0;                      ///< [temperatures]
  double tank_volume_ml = 0;                   ///< [tank] resin that the full tank holds
  std::string profile;                         ///< [print] name in board/profiles, where the user names none
  WiringFile wiring;                           ///< [display], [lamp_line], ...: empty where the printer is simulated

  /// mm of travel for one pulse of the driver.
  double step_mm() const { return rotation_distance_mm / (full_steps_per_rotation * microsteps); }
};

/// What a printer is, as its board file has it. Every number is inside the range that board/README.md gives.
struct BoardFile {
  std::string path;             ///< that it was read from; empty if it came from memory
  std::string name;             ///< [printer]
  std::uint32_t columns = 0;    ///< [panel] pixels along x
  std::uint32_t rows = 0;       ///< [panel] pixels along y
  double pixel_pitch_x_mm = 0;  ///< [panel] mm
  double pixel_pitch_y_mm = 0;  ///< [panel] mm
  double travel_mm = 0;         ///< [z_stage] mm, tallest print
  double layer_height_mm = 0;   ///< [print] mm
  std::uint32_t arena_mib = 0;  ///< [memory] MiB
  /// Absent where the file describes no more than slicing needs: it must have all of these keys or none.
  std::optional<MachineFile> machine;
};

/// Largest board file that is read, bytes.
inline constexpr std::size_t kMaxBoardFileBytes = kMaxSettingsFileBytes;

/// Reads a board file, which must be named after its printer.
/// @param name_or_path  see find_board_file()
/// @retval the errors of find_board_file(), check_file_name() and read_settings_file()
[[nodiscard]] Expected<BoardFile> read_board_file(const std::string& name_or_path);

/// The same from text in memory.
/// @param path  for messages only
[[nodiscard]] Expected<BoardFile> parse_board_file(std::string_view text, std::string_view path);

/// @retval ErrorCode::kBadSetting  the file lacks the keys that printing needs: which, and where they are explained
[[nodiscard]] Expected<MachineFile> machine_of(const BoardFile& board, std::string_view path);

/// The room that a printer has for an object.
PrinterVolume printer_volume(const BoardFile& board);

}  // namespace plumbline
