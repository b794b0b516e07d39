#include "firmware/print/sliced_scan.hpp"

#include "firmware/io/hashing_source.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/support_building.hpp"
#include "slicer/supports/mask_stream.hpp"

namespace plumbline {
namespace {

/// Counts the cured pixels, to compute the resin. Renders every mask unless slicing has counted them: milliseconds for a thousand
/// layers on a desktop, a minute for a large panel on a small board.
Status count_pixels(SlicedScan& sliced, Arena& arena, ProgressSink* progress, SliceReport& report) {
  const StageScope stage(Stage::kLayers, arena, progress, report.peak_bytes);
  if (const auto& totals = report.features.totals; totals && sliced.supports.empty()) {
    sliced.first_layer_pixels = totals->first_pixels;
    sliced.cured_pixels = totals->pixels;
    return {};
  }
  const std::uint32_t layers = sliced.rrep.grid.layers;
  const std::size_t bottom = arena.bottom_mark();
  auto stream = MaskStream::create(sliced.rrep, sliced.supports, arena);
  PLUMBLINE_TRY(stream);
  for (std::uint32_t layer = 0; layer < layers; ++layer) {
    if (progress != nullptr && !progress->advance(Stage::kLayers, static_cast<double>(layer) / layers)) {
      return fail(ErrorCode::kCancelled, "stopped while counting the resin, at layer %u of %u", layer, layers);
    }
    const std::uint64_t pixels = stream->mask(layer).count();
    if (layer == 0) sliced.first_layer_pixels = pixels;
    sliced.cured_pixels += pixels;
    sliced.support_pixels += stream->support_pixels();
  }
  arena.release_bottom(bottom);
  return {};
}

}  // namespace

Expected<SlicedScan> slice_for_print(ScanSources scan, const SliceSettings& settings,
                                     const std::optional<SupportSettings>& supports, Arena& arena,
                                     ProgressSink* progress, SliceReport& report) {
  const HashingSources hashing(scan);
  const auto rrep = slice(hashing.sources(), settings, arena, progress, report);
  PLUMBLINE_TRY(rrep);
  SlicedScan sliced;
  sliced.rrep = *rrep;
  sliced.scan_hash = hashing.hash();
  if (supports) {
    const auto found =
        add_supports(sliced.rrep, *supports, settings.placement, arena, progress, report, sliced.support_counts);
    PLUMBLINE_TRY(found);
    sliced.supports = *found;
  }
  PLUMBLINE_TRY(count_pixels(sliced, arena, progress, report));
  return sliced;
}

}  // namespace plumbline
