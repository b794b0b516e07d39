#pragma once
/// The back end over hal/linux. linux_back_end.cpp is the one file of the product that includes it.

#include <memory>
#include <string>
#include <vector>

#include "firmware/machine/back_end.hpp"
#include "firmware/machine/kept_lamp_line.hpp"

namespace plumbline::firmware {

/// @retval ErrorCode::kUnsupported  this build has no board devices
/// @retval ErrorCode::kBadSetting   the board file lacks wiring tables
[[nodiscard]] Status check_linux_back_end(const BoardFile& board, const MachineFile& machine);

/// Opens the devices of the board that this runs on. @pre check_linux_back_end()
/// @retval ErrorCode::kUnsupported  this build has no board devices
/// @retval ErrorCode::kBadSetting   the board file names a device that is not there
/// @retval ErrorCode::kCannotOpen, kLampFailed, ...  of one device: the message names it, what was found, what to do
[[nodiscard]] Expected<std::unique_ptr<BackEnd>> open_linux_back_end(const BoardFile& board,
                                                                     const MachineFile& machine);

/// Looks at the devices without moving or lighting anything.
/// @retval ErrorCode::kUnsupported  this build has no board devices
[[nodiscard]] Expected<std::vector<MachineFinding>> examine_linux_machine(const BoardFile& board,
                                                                          const MachineFile& machine);

/// Every build has it; without board devices it lists no GPIO lines.
std::vector<BoardPart> linux_board_parts();

/// Starts plumbline-keeper for one lamp line. Every build has it.
/// @param line     as the keeper's --line takes it
/// @param machine  its longest exposure and its watchdog
/// @retval ErrorCode::kLampFailed  the keeper could not be started
[[nodiscard]] Expected<std::unique_ptr<KeptLampLine>> keep_lamp_line(const std::string& line,
                                                                     const MachineFile& machine);

}  // namespace plumbline::firmware
