#pragma once
/// Pieces and bubbles of the object, and the specks among them (DESIGN 3, stage 7: never salt and pepper).

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/crossing_store.hpp"

namespace plumbline {

struct ComponentCounts {
  bool counted = false;               ///< false: the arena had no room to look, and everything stayed
  std::uint32_t solids = 0;           ///< connected solids that stay
  std::uint32_t cavities = 0;         ///< enclosed hollows that stay
  std::uint32_t dropped_solids = 0;   ///< solids taken out: specks and floating ones
  std::uint32_t floating_solids = 0;  ///< of them, those that are no specks
  std::uint32_t filled_cavities = 0;  ///< hollows filled: specks and sealed ones
  std::uint32_t sealed_cavities = 0;  ///< of them, those that are no specks
  std::uint64_t changed_voxels = 0;   ///< of both
  std::uint64_t voxels = 0;           ///< of the solids that stay
};

/// Bytes of arena that drop_small_components() takes.
std::size_t components_bytes(const PrintGrid& grid, double rays, double crossings);

struct ComponentLimits {
  std::uint64_t min_voxels = 0;    ///< fewer: a speck
  bool drop_floating = false;      ///< take out small pieces in the air, and fill small hollows
  std::uint32_t plate_layers = 0;  ///< a piece that begins so close to where the largest one begins stands on the plate
};

/// Takes out every solid that is a speck and touches no other, and fills every hollow that is one and does not reach the
/// outside. Voxels touch at faces. The largest piece always stays.
///
/// On request every solid goes, too, that does not stand on the plate and has less than a 500th of the largest one's
/// voxels: background that was scanned along. Printed, it would fall into the tank. And every hollow of fewer voxels is
/// filled: no scanner has looked into it, strays made it.
///
/// What lies inside of what goes stays as it is, and is one with it then: a speck of solid in a hollow that is filled.
///
/// Works on the stretches between the crossings of each ray, not on voxels: a stretch joins the ones it overlaps on the
/// rays beside it.
/// @param arena  components_bytes() from the top, given back
[[nodiscard]] ComponentCounts drop_small_components(CrossingStore& store, const ComponentLimits& limits, Arena& arena);

}  // namespace plumbline
