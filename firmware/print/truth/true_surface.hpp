#pragma once
/// Points of the true surface, which a simulated printer's part is measured against. For the desktop: uses the heap.

#include <string>
#include <vector>

#include "slicer/core/numbers/oriented_point.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware {

struct TrueSurface {
  std::string name;                   ///< of the mesh, or "r-rep"
  std::vector<OrientedPoint> points;  ///< print coordinates, mm
};

/// With what was measured.
struct MeasuredSurface : TrueSurface {
  std::vector<float> deviations_mm;  ///< Witness::deviations_mm() of the points
};

/// Leaves out the points that are within 0.5 mm of a support or the raft, where the part is not the object's, and those that lie below
/// the first layer.
void leave_out_supports(const Supports& supports, const PrintGrid& grid, std::vector<OrientedPoint>& points);

}  // namespace plumbline::firmware
