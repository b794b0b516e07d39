#pragma once
/// The template process. The firmware forks it when it starts, before it opens any device. The template gives up its rights and forks a
/// new child for each scan: so no scan sees what an earlier one left behind, and no program is started once the printer is ready.

#include <sys/types.h>

#include <cstdint>

#include "firmware/child/shared_memory.hpp"

namespace plumbline::firmware {

/// What a child does before it ends. Its only descriptor is 0, the scan.
using ChildTask = void (*)(SharedMemory& memory, std::uint32_t threads);

/// Runs the template until the firmware ends.
/// @param socket    to the firmware
/// @param firmware  its process ID
/// @param threads   of a child
[[noreturn]] void run_child_template(int socket, SharedMemory& memory, std::uint32_t threads, ChildTask task,
                                     pid_t firmware);

}  // namespace plumbline::firmware
