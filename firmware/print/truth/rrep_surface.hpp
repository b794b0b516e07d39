#pragma once
/// The surface of an R-Rep, as what is true where no mesh of it is known.

#include "firmware/print/truth/true_surface.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::firmware {

/// Spreads some 12,000 points evenly over the surface, always the same ones: planes through the faces between inside and outside, which lie at the
/// boundaries of pixels and the heights of crossings, weighted, within four pixels of a face. Leaves out edges, where the faces lie off a plane.
/// @param cure  by which the R-Rep is corrected for bleed; the surface is that before
TrueSurface surface_samples(const RRep& rrep, const CureModel& cure = {});

}  // namespace plumbline::firmware
