#pragma once

#include <string>

#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Sends a scan to the store of the printer that serves its state at `socket`, and waits until it is kept there.
/// @param file  a regular file. Its name in the store is upload_name_of()
/// @returns its name in the store
/// @retval ErrorCode::kCannotOpen, kCannotRead  the file, or the socket
/// @retval ErrorCode::kBadSetting               the printer does not take it: why, and what to do
/// @retval ErrorCode::kCannotWrite              it broke off: why. Nothing of it is kept
[[nodiscard]] Expected<std::string> upload_scan(const std::string& socket, const std::string& file);

}  // namespace plumbline::firmware
