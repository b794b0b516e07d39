#pragma once
/// Where a ray enters or leaves the object, and what tells so.

#include "slicer/rrep/confidence.hpp"

namespace plumbline {

struct RayCrossing {
  float depth = 0;  ///< mm
  Evidence evidence = Evidence::kMeasured;
  bool extrapolated = false;  ///< all points that tell of it lie to one side of it, as beyond an edge
};

}  // namespace plumbline
