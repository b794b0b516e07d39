#pragma once
/// The settings in an .sl1 archive: config.ini, which printers read, and prusaslicer.ini, which PrusaSlicer and UVtools read.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline {

/// What the settings say of a job.
struct Sl1Job {
  BoardFile board;
  PrintProfile profile;
  PrintGrid grid;
  double resin_ml = 0;
  double seconds = 0;  ///< that the print takes; 0: not known
};

/// Before the number of a layer's file: layer00000.png.
inline constexpr const char* kSl1Layer = "layer";

/// What was read of an archive's settings. Each number is plausible; the printer's limits are checked elsewhere.
struct Sl1Settings {
  std::optional<double> layer_height_mm;
  std::optional<double> first_layer_height_mm;  ///< its mask is as high as this
  std::optional<double> exposure_s, initial_exposure_s;
  std::optional<std::uint32_t> faded_layers;
  std::optional<std::uint32_t> layers;                        ///< of the print
  std::optional<double> width_mm, depth_mm;                   ///< of the panel, along x and y
  bool mirror_x = false, mirror_y = false, portrait = false;  ///< display_mirror_x, ...: PrusaSlicer's
};

/// Reads the lines of config.ini or prusaslicer.ini. Ignores unknown keys and lines without '='. Keeps what `settings` has already.
/// @retval ErrorCode::kMalformed  a known key whose value is no number in its range: the key and the value
[[nodiscard]] Status read_sl1_settings(std::string_view text, Sl1Settings& settings);

/// @returns "key = value" lines in the order of their keys
std::string sl1_config(const Sl1Job& job);
/// The same with PrusaSlicer's keys. Row 0 of a mask has the smallest y: that is display_mirror_y, since PrusaSlicer's first row has the
/// largest.
std::string sl1_prusaslicer(const Sl1Job& job);

}  // namespace plumbline
