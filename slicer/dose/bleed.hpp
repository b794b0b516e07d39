#pragma once
/// Corrects the object for light that cures deeper than the layers it is meant for.

#include <cstddef>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

struct BleedCounts {
  CureModel model;
  std::uint64_t moved = 0;  ///< crossings
  double mean_mm = 0;       ///< by which they were raised
  double most_mm = 0;
  std::uint64_t pixels = 0;  ///< of all masks together, that no longer cure
};

/// Raises the entering crossings of each ray until the front of the cured resin meets where they were: the bottom-most lit layer is the one
/// whose light, with that of the layers above it on the ray, cures down to the surface. Of a part too thin for that, the uppermost
/// layer stays. Crossings of layer 0 stay if the object stands on the plate. Masks are to half a layer height; the crossing's height has the rest.
/// @param rrep    of an object whose layer 0 is to be layer `lifted` of the print
/// @param model   is_known()
/// @param steps   layers of the print, those below the object with them
/// @retval ErrorCode::kOutOfMemory  no room for bleed_bytes() at the top of the arena; rrep is unchanged
[[nodiscard]] Expected<BleedCounts> correct_bleed(RRep& rrep, const CureModel& model, std::uint32_t lifted,
                                                  Arena& arena, const LayerSteps& steps = {});

/// Where the surface was before correct_bleed(): down to where the light of a ray cures, mm. Of parts that are too thin, only about.
/// @param depths     of the same model
/// @param height_mm  of a crossing at which a ray enters; layers count from the print's first
/// @param layer      of the crossing
/// @param exit       the first layer above the solid stretch
double uncorrected_mm(const CureDepths& depths, const PrintGrid& grid, double height_mm, std::uint32_t layer,
                      std::uint32_t exit);

/// What correct_bleed() takes at least.
std::size_t bleed_bytes(const PrintGrid& grid, std::size_t crossings);

}  // namespace plumbline::inline slicer
