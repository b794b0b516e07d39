#pragma once
/// Whether a mesh is closed, found in one pass and without its edges.

#include <algorithm>
#include <bit>
#include <cstdint>

#include "slicer/core/numbers/mix64.hpp"
#include "slicer/mesh/mesh_lattice.hpp"

namespace plumbline::inline slicer {

/// Sums a random number for each edge, with the sign of its direction. In a closed mesh with consistent faces every edge runs as
/// often one way as the other, and the sum is 0. Then every ray enters as often as it exits. Any other mesh has the sum 0 with a
/// probability of 2^-64.
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
  /// Adds another sum, or takes it away: that of the same triangles, all turned over.
  void add(const EdgeSum& other, bool turned) { sum_ += turned ? 0 - other.sum_ : other.sum_; }

  static std::uint64_t number_of(const LatticePoint& p) {
    const auto word = [](std::int32_t i) { return std::uint64_t{static_cast<std::uint32_t>(i)}; };
    return mix64(mix64(word(p.x) | word(p.y) << 32U) + word(p.z) * kGoldenStep64);
  }
  /// @param from, to  number_of() its ends
  static std::uint64_t number_of_edge(std::uint64_t from, std::uint64_t to) {
    return mix64(std::min(from, to) ^ std::rotl(std::max(from, to), 32));
  }

 private:
  void add(std::uint64_t from, std::uint64_t to) {
    if (from == to) return;
    const std::uint64_t edge = number_of_edge(from, to);
    sum_ += from < to ? edge : 0 - edge;
  }

  std::uint64_t sum_ = 0;
};

}  // namespace plumbline::inline slicer
