#pragma once
/// The command line of `plumblined`.

#include <cstddef>
#include <span>

#include "firmware/io/exit_code.hpp"

namespace plumbline {

/// Parses the arguments and runs the daemon until it is asked to end. @returns the process's exit code
/// @param arena_block  the program's static memory
ExitCode run_daemon_command_line(int argc, char** argv, std::span<std::byte> arena_block);

}  // namespace plumbline
