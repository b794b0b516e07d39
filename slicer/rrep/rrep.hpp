#pragma once
/// The ray representation of the object, kept until the print ends.

#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::inline slicer {

/// Crossings of all rays with the surface, sorted by layer (thesis III-1, LDNI without normals).
///
/// After repair every ray alternates entering and exiting, so one crossing toggles its pixel: the mask of layer k is the
/// mask of layer k - 1 with the pixels pixel[first[k]] ... pixel[first[k + 1] - 1] toggled. The mask before layer 0 is
/// black. A crossing belongs to the first layer whose sampling height (k + 1/2) layer_height is not below it; crossings
/// of one ray that fall between the same two sampling heights have cancelled in pairs. All memory is the arena's.
struct RRep {
  PrintGrid grid;
  std::span<const std::uint32_t> first;  ///< layers + 1 entries
  std::span<const std::uint32_t> pixel;  ///< row * columns + column, ascending within a layer, none twice in one
  bool is_exact = false;                 ///< of a mesh: a layer's mask is its section, not opened and closed

  std::size_t crossings() const { return pixel.size(); }
};

}  // namespace plumbline::inline slicer
