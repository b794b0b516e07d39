#pragma once
/// Opens the keeper's lines from their texts: what its command line takes, and what the firmware uses to take the lamp's line itself.

#include <memory>
#include <string_view>

#include "hal/linux/keeper/cover_line.hpp"
#include "hal/linux/keeper/lamp_line.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board {

/// @param text  of line_option(), or "file:PATH"
/// @retval ErrorCode::kBadSetting  another text
/// @retval ErrorCode::kCannotOpen  missing, busy or no permission
[[nodiscard]] Expected<std::unique_ptr<LampLine>> open_lamp_line(std::string_view text);

/// The same for the cover. @returns null if the text is empty: the printer has no switch
[[nodiscard]] Expected<std::unique_ptr<CoverLine>> open_cover_line(std::string_view text);

}  // namespace plumbline::inline hal::inline linux_board
