#pragma once
/// Compares a board with its board file: what is there, what is missing and what to do. Moves and lights nothing.

#include <vector>

#include "hal/linux/settings.hpp"
#include "hal/machine_finding.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Findings in the order in which to fix them. A device that a running plumbline holds is good.
std::vector<MachineFinding> examine_board(const LinuxSettings& settings);

}  // namespace plumbline::inline hal::inline linux_board
