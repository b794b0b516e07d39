#include <array>
#include <cstddef>
#include <cstdio>

#include "slicer/core/arena.hpp"
#include "slicer/core/vec.hpp"
#include "slicer/layers/layer_stream.hpp"

// Takes a block from an arena of its own: headers, flags and libraries of the installed package fit each other.
int main() {
  static std::array<std::byte, 4096> block;
  plumbline::Arena arena{block};
  const auto points = arena.take_top<float>(100, "consumer");
  if (!points) {
    std::fprintf(stderr, "%s\n", points.error().message());
    return 1;
  }
  const auto too_many = arena.take_top<plumbline::PrintGrid>(1000, "consumer");
  if (too_many) return 1;
  // From the slicer's library, so that it is linked.
  if (plumbline::LayerStream::bytes_needed({.columns = 64, .rows = 64, .layers = 1}) == 0) return 1;
  std::printf("plumbline %s, %zu bytes of the arena used\n", FOUND_VERSION, arena.used());
  return 0;
}
