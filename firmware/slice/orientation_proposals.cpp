#include "firmware/slice/orientation_proposals.hpp"

#include <algorithm>

#include "slicer/source_checks.hpp"

namespace plumbline::firmware {
namespace {

Proposal proposal_of(const WayUp& way) {
  const double mm = way.unit_mm;
  const WayUp::Supports supports = way.supports.value_or(WayUp::Supports());
  return {.degrees = way.degrees,
          .cost = way.cost.total,
          .support_mm2 = way.cost.support_area * mm * mm,
          .support_mm3 = way.cost.support_volume * mm * mm * mm,
          .peel_mm2 = way.cost.peel_area * mm * mm,
          .height_mm = way.height_mm,
          .scar_mm2 = way.cost.scar_area * mm * mm,
          .layers = way.layers,
          .counted = way.supports ? 1U : 0U,
          .tips = supports.tips,
          .tip_scars_mm2 = supports.scar_mm2,
          .supports_mm3 = supports.volume_mm3};
}

}  // namespace

std::size_t best_of(const Proposals& proposals) {
  return static_cast<std::size_t>(std::ranges::min_element(proposals, {}, &Proposal::cost) - proposals.begin());
}

Expected<Proposals> propose_orientations(const Cloud& cloud, const SurfaceSamples& samples, const ScanHeader& header,
                                         const SliceSettings& settings, Arena& arena, const StageProgress& progress) {
  SliceSettings printed = settings;
  printed.placement = heed_header(settings.placement, header);
  const auto ways = find_ways_up(cloud, samples, printed, arena, progress);
  PLUMBLINE_TRY(ways);
  Proposals proposals;
  std::ranges::transform(*ways, proposals.begin(), proposal_of);
  return proposals;
}

}  // namespace plumbline::firmware
