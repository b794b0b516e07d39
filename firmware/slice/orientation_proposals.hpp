#pragma once
/// The ways up that are proposed to whoever prints a scan, with what each costs.

#include <array>
#include <cstddef>
#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/reader/stream/scan_point.hpp"
#include "slicer/slice_settings.hpp"
#include "slicer/ways_up.hpp"

namespace plumbline::firmware {

/// A way up, and what it costs in mm of the print. Numbers only, so that no value of a byte is invalid.
struct Proposal {
  std::array<double, 2> degrees = {};  ///< about x, then about y: rotate_x_deg, rotate_y_deg
  double cost = 0;                     ///< OrientationCost::total: less is better
  double support_mm2 = 0;              ///< that needs supports
  double support_mm3 = 0;              ///< between it and the plate
  double peel_mm2 = 0;                 ///< of the largest layer
  double height_mm = 0;                ///< of the object
  double scar_mm2 = 0;                 ///< where supports may leave scars, counted more where the scan is better
  std::uint32_t layers = 0;            ///< of the print
  // WayUp::Supports.
  std::uint32_t counted = 0;  ///< 0: supports have not been counted
  std::uint32_t tips = 0;     ///< places that supports hold
  double tip_scars_mm2 = 0;   ///< where they touch the object
  double supports_mm3 = 0;    ///< volume of supports and raft
};

inline constexpr std::size_t kProposalCount = 1 + kBestOrientations;
/// The first is the scan as it came, the others are the best that differ from it, the best first.
using Proposals = std::array<Proposal, kProposalCount>;

/// The one that costs least: 0 if none is better than the scan as it came.
std::size_t best_of(const Proposals& proposals);

/// Finds them: find_ways_up().
/// @param header    sum_of() the files
/// @param settings  of the print; of placement.rotation_degrees, only that about z counts
/// @retval ErrorCode::kCancelled  progress said so
[[nodiscard]] Expected<Proposals> propose_orientations(const Cloud& cloud, const SurfaceSamples& samples,
                                                       const ScanHeader& header, const SliceSettings& settings,
                                                       Arena& arena, const StageProgress& progress);

}  // namespace plumbline::firmware
