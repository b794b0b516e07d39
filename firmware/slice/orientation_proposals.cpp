#include "firmware/slice/orientation_proposals.hpp"

#include <cmath>

#include "slicer/source_checks.hpp"

namespace plumbline::firmware {
namespace {

/// mm of the print in the unit of the scan, if the scan is turned.
double millimetres_of(const SurfaceSamples& samples, const std::array<double, 2>& degrees, double unit_mm,
                      PlacementSettings placing) {
  placing.rotation_degrees = {degrees[0], degrees[1], placing.rotation_degrees[2]};
  const Mat3d rotation = rotation_matrix(placing.rotation_degrees);
  Box3d box;
  for (const SurfaceSample& patch : samples.patches) box.extend(rotation * patch.position.cast<double>());
  if (placing.fit) {
    if (const auto placed = place(box, unit_mm, placing)) return placed->scale;
  }
  const double scale = scale_of(box.size() * unit_mm, placing);
  return std::isfinite(scale) ? unit_mm * scale : unit_mm;  // a flat side has no size
}

Proposal in_mm(const Orientation& o, double mm) {
  const OrientationCost& cost = o.cost;
  return {.degrees = o.degrees,
          .cost = cost.total,
          .support_mm2 = cost.support_area * mm * mm,
          .support_mm3 = cost.support_volume * mm * mm * mm,
          .peel_mm2 = cost.peel_area * mm * mm,
          .height_mm = cost.height * mm,
          .scar_mm2 = cost.scar_area * mm * mm};
}

}  // namespace

Expected<Proposals> propose_orientations(const SurfaceSamples& samples, const ScanHeader& header,
                                         const PlacementSettings& placement, const StageProgress& progress) {
  const auto best = best_orientations(samples, progress);
  if (!best) return fail(ErrorCode::kCancelled, "cancelled while looking for the best orientations");
  Box3d box;
  for (const SurfaceSample& patch : samples.patches) box.extend(patch.position.cast<double>());
  const PlacementSettings placing = heed_header(placement, header);
  const double unit_mm = millimetres_per(units_of(box, placing));
  Proposals proposals;
  const Orientation now{{0, 0}, cost_of(samples, {0, 0})};
  for (std::size_t i = 0; i < proposals.size(); ++i) {
    const Orientation& o = i == 0 ? now : (*best)[i - 1];
    proposals[i] = in_mm(o, millimetres_of(samples, o.degrees, unit_mm, placing));
  }
  return proposals;
}

}  // namespace plumbline::firmware
