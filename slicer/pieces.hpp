#pragma once
/// Pieces and bubbles of the object, and the specks among them (DESIGN 3, stage 7: never salt and pepper).

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep_builder.hpp"

namespace plumbline {

struct PieceCounts {
  bool counted = false;              ///< false: the arena had no room to look, and everything stayed
  std::uint32_t pieces = 0;          ///< connected solids that stay
  std::uint32_t bubbles = 0;         ///< enclosed hollows that stay
  std::uint32_t dropped_pieces = 0;  ///< specks of solid taken out
  std::uint32_t filled_bubbles = 0;  ///< specks of hollow filled
  std::uint64_t dropped_voxels = 0;  ///< of both
  std::uint64_t voxels = 0;          ///< of the solids that stay
};

/// Bytes of arena that drop_specks() takes.
std::size_t pieces_bytes(const PrintGrid& grid, double rays, double crossings);

/// Takes out every solid that has fewer than `fewest_voxels` voxels and touches no other, and fills every hollow of fewer
/// that does not reach the outside. Voxels touch at faces. The largest piece always stays.
///
/// Works on the stretches between the crossings of each ray, not on voxels: a stretch joins the ones it overlaps on the
/// rays beside it.
/// @param arena  pieces_bytes() from the top, given back
[[nodiscard]] PieceCounts drop_specks(CrossingStore& store, std::uint64_t fewest_voxels, Arena& arena);

}  // namespace plumbline
