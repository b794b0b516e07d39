/// The program `plumbline`: owns the arena and calls the rest.

#include <cstddef>

#include "firmware/cli/command_line.hpp"
#include "slicer/core/arena.hpp"

namespace {

constexpr std::size_t kArenaBytes = std::size_t{PLUMBLINE_ARENA_MIB} * 1024 * 1024;

/// All the memory of the slicer. It is in .bss, so untouched pages cost nothing.
alignas(plumbline::Arena::kAlignment) std::byte arena_block[kArenaBytes];

}  // namespace

int main(int argc, char** argv) {
  return static_cast<int>(plumbline::firmware::run_command_line(argc, argv, arena_block));
}
