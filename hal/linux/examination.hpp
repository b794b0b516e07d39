#pragma once
/// A look at a board: what is there of what its board file says, and what is not. Drives nothing and lights nothing.

#include <string>
#include <vector>

#include "hal/linux/linux_settings.hpp"

namespace plumbline {

/// What was found of one device or right.
struct BoardFinding {
  enum class Verdict : std::uint8_t {
    kGood,
    kPoor,   ///< it prints, but not as well as it could
    kWrong,  ///< it does not print
  } verdict = Verdict::kGood;
  std::string what;    ///< "the lamp's line"
  std::string found;   ///< "gpiochip0 line 17"
  std::string advice;  ///< what to do; empty where nothing
};

/// In the order in which one would put things right. A device that another program has, such as a daemon that runs, is good.
std::vector<BoardFinding> examine_board(const LinuxSettings& settings);

}  // namespace plumbline
