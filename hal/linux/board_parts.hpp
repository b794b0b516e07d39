#pragma once
/// Lists the devices of the board that this runs on. Opens no line, moves and lights nothing.

#include <string>
#include <vector>

#include "hal/board_part.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Connectors with their modes, GPIO lines, fans, temperature sensors, USB devices, watchdogs, touch panels and serial ports, in
/// this order and each kind by name. What can't be read is left out.
/// @param sysfs, dev  where the kernel shows them
std::vector<BoardPart> list_board_parts(const std::string& sysfs = "/sys", const std::string& dev = "/dev");

}  // namespace plumbline::inline hal::inline linux_board
