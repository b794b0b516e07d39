#pragma once
/// The command line of `plumbline`.

#include <cstddef>
#include <span>

#include "firmware/cli/commands.hpp"

namespace plumbline::firmware {

/// Parses the arguments and runs the subcommand.
/// @param arena_block  the program's static memory
/// @returns the process's exit code
ExitCode run_command_line(int argc, char** argv, std::span<std::byte> arena_block);

}  // namespace plumbline::firmware
