#pragma once
/// Meshes that are sliced, and what their sections must hold.

#include <cmath>

#include "tests/slicer/support/meshes.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline::testing {

inline constexpr std::size_t kArena = 64 * kMiB;

inline Slicing sliced(const TestMesh& mesh, const SliceSettings& settings) {
  return {MemorySource(binary_stl(mesh), "mesh.stl"), settings, kArena};
}

/// Voxels of the sections whose centres `inside` contradicts, of those that `inside` is sure of (it returns 0 elsewhere).
template <class Inside>
std::uint64_t wrong(const Slicing& slicing, Inside inside) {
  std::uint64_t wrong = 0;
  slicing.for_each_section([&](std::uint32_t k, ConstBitImage section) {
    for (std::uint32_t r = 0; r < slicing.grid().rows; ++r) {
      for (std::uint32_t c = 0; c < slicing.grid().columns; ++c) {
        const int expected = inside(slicing.middle_of(c, r, k));
        wrong += expected != 0 && (expected > 0) != section.at(c, r) ? 1 : 0;
      }
    }
  });
  return wrong;
}

inline int in_box(const Vec3d& p, const Vec3d& low, const Vec3d& high, double unsure = 1e-4) {
  const double out = std::max((low - p).maxCoeff(), (p - high).maxCoeff());
  return std::abs(out) < unsure ? 0 : out < 0 ? 1 : -1;
}

}  // namespace plumbline::testing
