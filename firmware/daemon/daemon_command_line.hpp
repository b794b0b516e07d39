#pragma once
/// The command line of `plumblined`.

#include <cstddef>

#include "firmware/messages/exit_code.hpp"

namespace plumbline::firmware {

/// Parses the arguments and runs the daemon until it is asked to end. @returns the process's exit code
/// @param largest_arena  bytes that a board file may ask for
ExitCode run_daemon_command_line(int argc, char** argv, std::size_t largest_arena);

}  // namespace plumbline::firmware
