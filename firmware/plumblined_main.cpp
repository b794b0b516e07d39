/// The program `plumblined`. Its arena is shared memory of the size that the board file asks for.

#include <cstddef>

#include "firmware/daemon/daemon_command_line.hpp"

int main(int argc, char** argv) {
  constexpr std::size_t kLargestArena = std::size_t{PLUMBLINE_ARENA_MIB} * 1024 * 1024;
  return static_cast<int>(plumbline::firmware::run_daemon_command_line(argc, argv, kLargestArena));
}
