#include "slicer/support_building.hpp"

#include <algorithm>

#include "slicer/checks/what_matters.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/layers/rrep_edit.hpp"
#include "slicer/supports/stand.hpp"

namespace plumbline::inline slicer {
namespace {

std::uint32_t most_layers(const PlacementSettings& placement) {
  if (!placement.printer) return PrintGrid::kMaxLayers;
  return static_cast<std::uint32_t>(
      std::max(1.0, whole_layers(placement.printer->travel_mm, placement.layer_height_mm)));
}

/// Corrects the other rays of each pixel for bleed, gives them ray 0's layers, and lets them stand as that does.
/// @param rrep  with its supports
Status follow(const RRep& rrep, const SupportCounts& counts, const CureModel& cure, Arena& arena) {
  for (RRep& other : rrep.other_rays()) {
    cut_layers(other, {.below = counts.sunk, .above = 0});
    if (cure.is_known()) {
      PLUMBLINE_TRY(correct_bleed(other, cure, counts.lifted, arena, counts.steps));
    } else if (!counts.steps.all_one()) {
      take_steps(other, counts.steps, counts.lifted);
    }
    cut_layers(other, {.below = 0, .above = other.grid.layers + counts.lifted - rrep.grid.layers});
    if (counts.lifted > 0) PLUMBLINE_TRY(raise_object(other, counts.lifted, arena));
  }
  return {};
}

}  // namespace

Expected<Supports> add_supports(RRep& rrep, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                                SliceReport& report, SupportCounts& counts) {
  const bool adaptive = settings.adaptive.wanted();
  if (!settings.supports && !settings.cure.is_known() && !adaptive) return Supports{};
  const StageScope stage(Stage::kSupports, {arena, progress, report});
  const std::size_t bleed = std::max(settings.cure.is_known() ? bleed_bytes(rrep.grid, rrep.crossings()) : 0,
                                     adaptive ? steps_bytes(rrep.grid, 0) : 0);
  if (!settings.supports) {
    report.planned(Stage::kSupports) = arena.used() + bleed;
    if (adaptive) {
      const auto steps = choose_steps(rrep, settings.adaptive, 0, settings.cure, arena);
      PLUMBLINE_TRY(steps);
      counts.steps = *steps;
    }
    if (!settings.cure.is_known()) {
      take_steps(rrep, counts.steps, 0);
      report.object_pixels.reset();
      PLUMBLINE_TRY(follow(rrep, counts, settings.cure, arena));
      return Supports{};
    }
    const auto corrected = correct_bleed(rrep, settings.cure, 0, arena, counts.steps);
    PLUMBLINE_TRY(corrected);
    counts.bleed = *corrected;
    if (report.object_pixels && rrep.is_exact && !adaptive) {
      *report.object_pixels -= corrected->pixels;
    } else {
      report.object_pixels.reset();  // small features are removed anew
    }
    PLUMBLINE_TRY(follow(rrep, counts, settings.cure, arena));
    return Supports{};
  }
  const SupportSettings& wanted = *settings.supports;
  report.planned(Stage::kSupports) = arena.used() + std::max(bleed, find_supports_bytes(rrep, wanted));
  auto supports = find_supports(rrep, wanted, most_layers(settings.placement), arena, progress, counts, settings.cure,
                                settings.adaptive);
  PLUMBLINE_TRY(supports);
  PLUMBLINE_TRY(follow(rrep, counts, settings.cure, arena));
  for (std::uint32_t i = 0; i < wanted.added.all().size(); ++i) {
    SupportPlaces& missed = report.missed_supports;
    if ((counts.missed >> i & 1U) != 0) missed.list[missed.count++] = wanted.added.list[i];
  }
  const double layer_height = rrep.grid.layer_height_mm;
  if (counts.sunk > 0) {
    report.confidence.trim(counts.sunk, 0);
    report.placement.shift[2] -= counts.sunk * layer_height;
    report.placement.size_mm[2] -= counts.sunk * layer_height;
    report.printed_mm[2] -= counts.sunk * layer_height;
    report.sunk_layers = counts.sunk;
  }
  if (report.object_pixels && counts.lost_pixels) {
    *report.object_pixels -= *counts.lost_pixels;
  } else {
    report.object_pixels.reset();
  }
  if (counts.lifted > 0) {
    PLUMBLINE_TRY(report.confidence.raise(counts.lifted, arena));
    report.placement.shift[2] += counts.lifted * layer_height;
  }
  report.placement.grid.layers = rrep.grid.layers;
  return supports;
}

void finish_findings(StackFindings& findings, const Supports& supports, const SupportCounts& counts,
                     const SliceReport& report) {
  const auto add = [&](IssueKind kind, const UnreachedTips& unreached) {
    if (unreached.count == 0) return;
    const Tip& tip = unreached.largest;
    const std::uint64_t load = std::max(tip.load, 1U);  // the load leaves out what the tip itself would hold
    IssueGroup& group = findings.of(kind);
    group.add({kind, tip.layer, tip.layer, tip.layer, tip.column, tip.row, load, load});
    group.count = unreached.count;
  };
  add(IssueKind::kUnreached, counts.unreached_overhangs);
  add(IssueKind::kUnreachedIsland, counts.unreached_islands);
  find_what_matters(findings, report.placement.grid,
                    {.drawn = counts.all() > 0 || counts.pads > 0,
                     .raft_layers = counts.lifted,
                     .object_clear = report.extent.keeps_off_edge(report.placement.grid, kEdgeMargin),
                     .struts = supports.list});
}

PlacementRoom support_room(const SupportSettings& settings) {
  return {.beside_mm = settings.head_width + settings.base_diameter / 2 + settings.pad_brim_size,
          .below_mm = lift_mm(settings)};
}

}  // namespace plumbline::inline slicer
