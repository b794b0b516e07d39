#pragma once

#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline page {

/// Gives up, for good, what the page does not need: capabilities, files (Landlock, where the kernel has it) and debugging. Of the system
/// calls it keeps those for its own sockets, Unix sockets, memory and time. Others fail with EPERM.
/// @pre everything is open but the state socket
/// @retval ErrorCode::kUnsupported  the kernel lacks it
[[nodiscard]] Status give_up_page_rights();

}  // namespace plumbline::firmware::inline page
