#include "firmware/print/job/sliced_scan.hpp"

#include "firmware/io/hashing_source.hpp"
#include "firmware/print/job/mask_renderer.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/proof_report.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/layers/morphology.hpp"
#include "slicer/support_building.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"

namespace plumbline::firmware {
namespace {

/// Makes a mask what the print shows of it.
/// @param drawn  as for LayerStream::draw_on_mask()
/// @returns number of pixels that it loses
std::uint64_t shrink(BitImage image, std::uint32_t steps, std::span<std::uint64_t> rows, BitImage drawn) {
  const std::uint64_t before = image.count();
  for (std::uint32_t r = 0; r < image.rows(); ++r) {
    const auto row = image.row(r);
    for (std::uint32_t strip = 0; strip * kStripColumns < image.columns(); ++strip) {
      if (row[strip * kStripColumns / 64] != 0) drawn.set(r, strip);
    }
  }
  erode(image, steps, rows);
  return before - image.count();
}

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
  const PrintGrid& mm = sliced.rrep.grid;
  const auto rows = arena.take_top<std::uint64_t>(3 * BitImage::words_needed(mm.columns, 1), "checks");
  PLUMBLINE_TRY(rows);
  const LayerSteps& heights = sliced.support_counts.steps;
  std::uint64_t shrunk = 0;
  const auto draw = [&](std::uint32_t layer) {
    const ConstBitImage mask = stream->mask(layer);
    if (const std::uint32_t steps = settings.foot.steps(heights.layer_at(layer), static_cast<double>(mm.pitch_x_mm),
                                                        static_cast<double>(mm.pitch_y_mm))) {
      stream->draw_on_mask([&](BitImage image, BitImage drawn) { shrunk += shrink(image, steps, *rows, drawn); });
    }
    return mask;
  };
  ConstBitImage mask = draw(0);
  for (std::uint32_t layer = 0; layer < layers; ++layer) {
    if (progress != nullptr && !progress->advance(Stage::kLayers, static_cast<double>(layer) / layers)) {
      return fail(ErrorCode::kCancelled, "stopped while the layers were checked, at layer %u of %u", layer, layers);
    }
    checker->take(mask);
    sliced.support_pixels += stream->support_pixels();
    checker->check_while([&] {
      if (layer + 1 < layers) mask = draw(layer + 1);
    });
  }
  sliced.findings = checker->finish();
  finish_findings(sliced.findings, sliced.supports, sliced.support_counts, report);
  if (report.object_pixels) sliced.support_pixels = sliced.findings.voxels + shrunk - *report.object_pixels;
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
