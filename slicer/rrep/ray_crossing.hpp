#pragma once
/// Where a ray enters or leaves the object, and the evidence for it.

#include "slicer/rrep/confidence.hpp"

namespace plumbline::inline slicer {

struct RayCrossing {
  float depth = 0;  ///< mm
  Evidence evidence = Evidence::kMeasured;
  bool extrapolated = false;  ///< its points all lie to one side, as beyond an edge
};

}  // namespace plumbline::inline slicer
