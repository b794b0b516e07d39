#pragma once
/// The ways up that are proposed to whoever prints a scan, with what each costs.

#include <array>
#include <cstddef>

#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/orientation/orientations.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::firmware {

/// A way up, and what it costs in mm of the print.
struct Proposal {
  std::array<double, 2> degrees = {};  ///< about x, then about y: rotate_x_deg, rotate_y_deg
  double cost = 0;                     ///< OrientationCost::total: less is better
  double support_mm2 = 0;              ///< that needs supports
  double support_mm3 = 0;              ///< between it and the plate
  double peel_mm2 = 0;                 ///< of the largest layer
  double height_mm = 0;                ///< of the object
  double scar_mm2 = 0;                 ///< where supports leave scars, counted more where the scan is better
};

inline constexpr std::size_t kProposalCount = 1 + kBestOrientations;
/// The first is the scan as it lies, the others are the best ways up, the best first.
using Proposals = std::array<Proposal, kProposalCount>;

/// Finds them. A size that was asked for holds for each way up, so their scales differ.
/// @param samples    of the scan as it lies
/// @param header     sum_of() the files
/// @param placement  rotation_degrees[2] turns the object as it stands; the other two are not used
/// @retval ErrorCode::kCancelled  progress said so
[[nodiscard]] Expected<Proposals> propose_orientations(const SurfaceSamples& samples, const ScanHeader& header,
                                                       const PlacementSettings& placement,
                                                       const StageProgress& progress);

}  // namespace plumbline::firmware
