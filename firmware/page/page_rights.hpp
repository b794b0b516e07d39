#pragma once

#include "slicer/core/error.hpp"

namespace plumbline {

/// Gives up, for good, what the page does not need: capabilities, files (Landlock, where the kernel has it), debugging, and every system call
/// but those for the sockets that it has, for Unix sockets, for memory and for the time. A call that is not allowed fails with EPERM.
/// @pre everything is open but the state socket
/// @retval ErrorCode::kUnsupported  the kernel lacks it
[[nodiscard]] Status give_up_page_rights();

}  // namespace plumbline
