#pragma once
/// The template process: forked from the firmware at its start, before any device is open. It has no rights and forks one child for each
/// scan, so that no scan meets what another one left behind, and no program is started once the printer is ready.

#include <sys/types.h>

#include <cstdint>

#include "firmware/child/shared_memory.hpp"

namespace plumbline {

/// What a child does, then it ends. Its descriptor 0 is the scan; it has no other.
using ChildTask = void (*)(SharedMemory& memory, std::uint32_t threads);

/// Runs the template until the firmware ends.
/// @param socket    to the firmware
/// @param firmware  its process ID
/// @param threads   of a child
[[noreturn]] void run_child_template(int socket, SharedMemory& memory, std::uint32_t threads, ChildTask task,
                                     pid_t firmware);

}  // namespace plumbline
