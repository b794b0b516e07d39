/// The program `plumblined`: owns the arena and calls the rest.

#include <cstddef>

#include "firmware/daemon/daemon_command_line.hpp"
#include "slicer/core/arena.hpp"

namespace {

constexpr std::size_t kArenaBytes = std::size_t{PLUMBLINE_ARENA_MIB} * 1024 * 1024;

/// All the memory for slicing and printing. It is in .bss, so untouched pages cost nothing.
alignas(plumbline::Arena::kAlignment) std::byte arena_block[kArenaBytes];

}  // namespace

int main(int argc, char** argv) {
  return static_cast<int>(plumbline::run_daemon_command_line(argc, argv, arena_block));
}
