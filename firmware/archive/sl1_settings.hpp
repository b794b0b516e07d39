#pragma once
/// The settings in an .sl1 archive: config.ini, which printers read, and prusaslicer.ini, which PrusaSlicer and UVtools read.

#include <cstdint>
#include <string>

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

/// @returns "key = value" lines in the order of their keys
std::string sl1_config(const Sl1Job& job);
/// The same with PrusaSlicer's keys. Row 0 of a mask has the smallest y: that is display_mirror_y, since PrusaSlicer's first row has the
/// largest.
std::string sl1_prusaslicer(const Sl1Job& job);

}  // namespace plumbline
