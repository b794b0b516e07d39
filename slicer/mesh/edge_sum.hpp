#pragma once
/// Whether a mesh is closed, found in one pass and without its edges.

#include <algorithm>
#include <bit>
#include <cstdint>

#include "slicer/core/numbers/mix64.hpp"
#include "slicer/mesh/mesh_lattice.hpp"

namespace plumbline {

/// Sums a random number for each edge, with the sign of its direction. In a closed mesh with consistent faces every edge runs as
/// often one way as the other, and the sum is 0. Then every ray enters as often as it exits. Any other mesh has the sum 0 with a
/// probability of 2^-64.
///
/// A second sum, bit by bit modulo 2, knows no direction. It is 0 if every edge belongs to an even number of triangles. Then every
/// ray passes an even number of them, whichever way they face.
class EdgeSum {
 public:
  void add(const LatticeTriangle& triangle) {
    const std::uint64_t a = number_of(triangle[0]);
    const std::uint64_t b = number_of(triangle[1]);
    const std::uint64_t c = number_of(triangle[2]);
    add(a, b);
    add(b, c);
    add(c, a);
  }
  bool is_closed() const { return sum_ == 0; }
  bool is_paired() const { return parity_ == 0; }

 private:
  static std::uint64_t number_of(const LatticePoint& p) {
    const auto word = [](std::int32_t i) { return std::uint64_t{static_cast<std::uint32_t>(i)}; };
    return mix64(mix64(word(p.x) | word(p.y) << 32U) + word(p.z) * kGoldenStep64);
  }
  void add(std::uint64_t from, std::uint64_t to) {
    if (from == to) return;
    const std::uint64_t edge = mix64(std::min(from, to) ^ std::rotl(std::max(from, to), 32));
    sum_ += from < to ? edge : 0 - edge;
    parity_ ^= edge;
  }

  std::uint64_t sum_ = 0;
  std::uint64_t parity_ = 0;
};

}  // namespace plumbline
