#pragma once

#include "firmware/messages/exit_code.hpp"

namespace plumbline::firmware::inline page {

/// The program `plumbline-page`.
ExitCode run_page_command_line(int argc, char** argv);

}  // namespace plumbline::firmware::inline page
