#include "firmware/print/job/sliced_scan.hpp"

#include "firmware/io/hashing_source.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/proof_report.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/support_building.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"

namespace plumbline::firmware {
namespace {

/// Checks every mask, and counts what will cure. On a desktop it takes a second or two for a thousand layers of a large panel.
Status check_masks(SlicedScan& sliced, const SliceSettings& settings, OverhangRule overhangs, Arena& arena,
                   ProgressSink* progress, SliceReport& report) {
  const StageScope stage(Stage::kLayers, {arena, progress, report});
  const ArenaScope scratch(arena);
  const std::uint32_t layers = sliced.rrep.grid.layers;
  const std::size_t bottom = arena.bottom_mark();
  auto stream = MaskStream::create(sliced.rrep, sliced.supports, arena, !report.object_pixels);
  PLUMBLINE_TRY(stream);
  auto checker = StackChecker::create(
      sliced.rrep.grid, check_limits(settings.placement, settings.peel, settings.overcure_mm, overhangs), arena);
  PLUMBLINE_TRY(checker);
  ConstBitImage mask = stream->mask(0);
  for (std::uint32_t layer = 0; layer < layers; ++layer) {
    if (progress != nullptr && !progress->advance(Stage::kLayers, static_cast<double>(layer) / layers)) {
      return fail(ErrorCode::kCancelled, "stopped while the layers were checked, at layer %u of %u", layer, layers);
    }
    checker->take(mask);
    sliced.support_pixels += stream->support_pixels();
    checker->check_while([&] {
      if (layer + 1 < layers) mask = stream->mask(layer + 1);
    });
  }
  sliced.findings = checker->finish();
  finish_findings(sliced.findings, sliced.supports, sliced.support_counts, report);
  if (report.object_pixels) sliced.support_pixels = sliced.findings.voxels - *report.object_pixels;
  arena.release_bottom(bottom);
  return {};
}

}  // namespace

Expected<SlicedScan> slice_for_print(ScanSources scan, const SliceSettings& settings, Arena& arena,
                                     ProgressSink* progress, SliceReport& report) {
  const HashingSources hashing(scan);
  const auto rrep = slice(hashing.sources(), settings, arena, progress, report);
  PLUMBLINE_TRY(rrep);
  PLUMBLINE_TRY(check_proof(report.proof, scan));
  SlicedScan sliced;
  sliced.rrep = *rrep;
  sliced.proof = report.proof;
  sliced.scan_hash = hashing.hash();
  const auto found = add_supports(sliced.rrep, settings, arena, progress, report, sliced.support_counts);
  PLUMBLINE_TRY(found);
  sliced.supports = *found;
  PLUMBLINE_TRY(check_masks(sliced, settings, rule_for(settings.supports), arena, progress, report));
  return sliced;
}

}  // namespace plumbline::firmware
