#pragma once
/// The command line of `plumbline`.

#include <cstddef>
#include <span>

#include "firmware/cli/commands.hpp"

namespace plumbline {

/// Parses the arguments, does what they say, and tells what the process is to return.
/// @param arena_block  the program's static memory
ExitCode run_command_line(int argc, char** argv, std::span<std::byte> arena_block);

}  // namespace plumbline
