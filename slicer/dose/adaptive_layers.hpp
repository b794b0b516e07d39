#pragma once
/// Layers as high as the surface allows: thin where shallow tops make stairs, thick where walls are steep.

#include <cstddef>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/core/resin/layer_steps.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// What an adaptive print asks for. Heights are in layers of the R-Rep, which are the finest.
struct AdaptiveLayers {
  std::uint32_t most = 0;          ///< odd, 3 to LayerSteps::kMostStep; 0: the print is not adaptive
  std::uint32_t first = 1;         ///< height of the bottom and faded layers; odd
  std::uint32_t first_layers = 0;  ///< how many those are

  bool wanted() const { return most > 0; }
};

/// Chooses the layers of a print. A layer of height h makes stairs of h cos(t) on a surface that is tilted by t, from its peaks to its notches (the
/// cusp height of Dolenc and Maekelae, 1994); these are to be no higher than kMostCusp of the finest layers. A surface is that flat or flatter if it
/// crosses four rays side by side within 2 pitch tan(t) of height.
/// @param rrep    of an object whose layer 0 is to be layer `lifted` of the R-Rep of the print; empty layers below it are as high as may be
/// @param cure    if it is known, the object is to be corrected for bleed with it
/// @param arena   steps_bytes() are needed at the top
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<LayerSteps> choose_steps(const RRep& rrep, const AdaptiveLayers& asked, std::uint32_t lifted,
                                                const CureModel& cure, Arena& arena);
inline constexpr double kMostCusp = 1.35;

/// The layers of an object that are a print's, while these and not the R-Rep's are counted.
struct PrintLayers {
  std::uint32_t first = 0;        ///< the lowest layer of the print that samples the object
  std::uint32_t rrep_layers = 0;  ///< of the object
};

/// Makes the layers of an R-Rep those of its print: each has the crossings up to where its mask is sampled, from where the one below is. Those that have
/// moved are at the underside of their layer. Its memory stays where it is.
/// @param rrep    of an object whose layer 0 is to be layer `lifted` of the R-Rep of the print
/// @param steps   not all_one()
PrintLayers count_print_layers(RRep& rrep, const LayerSteps& steps, std::uint32_t lifted);
/// Gives an R-Rep its own layers back: those that a layer of the print consists of are alike.
void count_rrep_layers(RRep& rrep, const PrintLayers& counted, const LayerSteps& steps, std::uint32_t lifted);

/// Both, one after the other: the masks of an R-Rep become those of its print. correct_bleed() does it, too.
inline void take_steps(RRep& rrep, const LayerSteps& steps, std::uint32_t lifted) {
  const PrintLayers counted = count_print_layers(rrep, steps, lifted);
  count_rrep_layers(rrep, counted, steps, lifted);
}

std::size_t steps_bytes(const PrintGrid& grid, std::uint32_t lifted);

}  // namespace plumbline::inline slicer
