#pragma once
/// What became of a scan's normals.

#include <cstdint>

namespace plumbline::inline slicer {

struct NormalCounts {
  std::uint32_t estimated =
      0;  ///< normals that the scan did not have, or that contradict the neighbours where they are splats' or not the surface's
  std::uint32_t turned = 0;    ///< normals of the scan that faced into the object
  bool inside_out = false;     ///< the scan's normals as a whole faced into the object
  bool contradictory = false;  ///< they faced either side at random
};

}  // namespace plumbline::inline slicer
