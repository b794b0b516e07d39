#pragma once
/// Finds the solid and hollow components of the object and removes small ones.

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/crossing_store.hpp"

namespace plumbline::inline slicer {

struct ComponentCounts {
  bool counted = false;               ///< false: the arena had no room, and nothing was removed
  std::uint32_t solids = 0;           ///< solid components that stay
  std::uint32_t cavities = 0;         ///< cavities that stay
  std::uint32_t dropped_solids = 0;   ///< solids removed: small and floating ones
  std::uint32_t floating_solids = 0;  ///< of those, the ones with min_voxels or more
  std::uint32_t filled_cavities = 0;  ///< cavities filled: small and sealed ones
  std::uint32_t sealed_cavities = 0;  ///< of those, the ones with min_voxels or more
  std::uint64_t changed_voxels = 0;   ///< of all components removed or filled
  std::uint64_t dropped_voxels = 0;   ///< of the solids removed
  std::uint64_t voxels = 0;           ///< of the solids that stay
};

/// Bytes of arena that drop_small_components() takes.
/// @param rays, crossings  how many there will be
std::size_t components_bytes(const PrintGrid& grid, double rays, double crossings);

struct ComponentLimits {
  std::uint64_t min_voxels = 0;    ///< smaller components are removed or filled
  bool drop_floating = false;      ///< also remove floating solids and fill sealed cavities
  std::uint32_t plate_layers = 0;  ///< a solid that begins this close to where the largest begins stands on the plate
};

/// Removes solid components and fills cavities of fewer than `min_voxels`. Voxels are joined at faces. The largest solid
/// always stays, and so does what has a 20th of its voxels and a quarter of `min_voxels`.
///
/// With `drop_floating` it also removes floating solids: those that do not stand on the plate and have less than a 500th of
/// the largest solid's voxels. They are scanned background, and would fall into the tank. Sealed cavities of fewer voxels than
/// that are filled: no scanner can have looked into them, so outliers made them.
///
/// A component inside a removed one becomes part of it unchanged: a solid in a cavity that is filled.
///
/// Works on the intervals between the crossings of each ray, not on voxels: an interval joins those that it overlaps on
/// neighbouring rays.
/// @param arena  components_bytes() from the top, given back
[[nodiscard]] ComponentCounts drop_small_components(CrossingStore& store, const ComponentLimits& limits, Arena& arena);

}  // namespace plumbline::inline slicer
