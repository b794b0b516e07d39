#pragma once
/// Which share of a layer's light a ray gets that enters the object between its height and the next one's.

#include <array>
#include <cstdint>

#include "slicer/core/grey_runs.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// The least share of a layer's light with which the front of the cured resin lies `share` of a layer higher than with all of it, if the
/// layers above are lit. Solves combined(g) = Ec for the dose of CureModel.
/// @param share  0 to 1
/// @returns 0 to 1, the same on every machine; 1 - share if the model is not known
double grey_of(const CureModel& model, double layer_height_mm, double share);

/// That share as a level, with limits that keep what the checks of the masks expect.
struct EnteringLevels {
  /// @param layer_height_mm  by which the plate moves
  EnteringLevels(const CureModel& model, double layer_height_mm);

  std::array<std::uint8_t, CrossingHeight::kParts> by_part = {};  ///< of a crossing's height; 0: no light, 255: all
  std::uint32_t least = kLeastCuringLevel;  ///< that cures by itself, and that whoever reads the mask takes for white
  std::uint32_t most_alone = kFullLevel;    ///< of a pixel that is to cure with the next layer's light only
};

}  // namespace plumbline::inline slicer
