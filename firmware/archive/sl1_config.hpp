#pragma once
/// The settings that plumbline puts into an .sl1 archive: config.ini, which printers read, and prusaslicer.ini, which PrusaSlicer and UVtools read.

#include <string>

#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::firmware::inline archive {

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
/// The same with PrusaSlicer's keys. What .sl1 has no key for, such as lifts, is in its printer_notes: see kNoteKeys.
std::string sl1_prusaslicer(const Sl1Job& job);

/// A board as a printer of PrusaSlicer or UVtools, with the lifts of its profile. What they slice with it lies as the board's own masks do,
/// in black and white.
std::string slicer_printer(const BoardFile& board, const MachineFile& machine, const PrintProfile& profile);
/// A profile as PrusaSlicer's material and print settings.
std::string slicer_print(const PrintProfile& profile);

}  // namespace plumbline::firmware::inline archive
