#include "firmware/print/sliced_archive.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "firmware/io/mask_hash.hpp"
#include "firmware/print/layer_crossings.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/told/printer_code.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline {
namespace {

Status check_layers(LayerArchive& archive, const CheckLimits& limits, SlicedArchive& sliced,
                    std::span<ArchiveLayer> layers, Arena& arena, ProgressSink* progress) {
  const PrintGrid& grid = sliced.grid;
  std::array<std::size_t, kStageCount> peaks = {};
  const StageScope stage(Stage::kLayers, arena, progress, peaks);
  const ArenaScope scratch(arena);
  const std::size_t words = BitImage::words_needed(grid.columns, grid.rows);
  const auto two = arena.take_top<std::uint64_t>(2 * words, "masks");
  PLUMBLINE_TRY(two);
  BitImage mask(two->first(words), grid.columns, grid.rows), below(two->last(words), grid.columns, grid.rows);
  below.clear();
  auto checker = StackChecker::create(grid, limits, arena);
  PLUMBLINE_TRY(checker);
  LayerCrossings crossings = LayerCrossings::make(grid, arena);
  for (std::uint32_t layer = 0; layer < grid.layers; ++layer) {
    if (progress != nullptr && !progress->advance(Stage::kLayers, static_cast<double>(layer) / grid.layers)) {
      return fail(ErrorCode::kCancelled, "stopped while the layers were checked, at layer %u of %u", layer,
                  grid.layers);
    }
    PLUMBLINE_TRY(archive.read(layers[layer], mask));
    layers[layer].hash = mask_hash(mask);
    checker->next(mask);
    sliced.extent.hold(mask);
    crossings.next(layer, mask, below);
    std::swap(mask, below);
  }
  sliced.findings = checker->finish();
  sliced.rrep = crossings.rrep(grid);
  return {};
}

}  // namespace

void MaskExtent::hold(ConstBitImage mask) {
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    const auto row = mask.row(r);
    const auto is_white = [](std::uint64_t word) { return word != 0; };
    const auto first = std::find_if(row.begin(), row.end(), is_white);
    if (first == row.end()) continue;
    const auto last = std::find_if(row.rbegin(), row.rend(), is_white);
    const auto words_before = [&row](auto at) { return static_cast<std::uint32_t>(at - row.begin()); };
    left = std::min(left, 64 * words_before(first) + static_cast<std::uint32_t>(std::countr_zero(*first)));
    right = std::max(right, 64 * words_before(last.base()) - static_cast<std::uint32_t>(std::countl_zero(*last)));
    top = std::min(top, r);
    bottom = std::max(bottom, r + 1);
  }
}

Status check_panel(const LayerArchive& archive, std::string_view name, const PrinterVolume& printer) {
  const PrintableText shown = name;
  if (archive.columns() != printer.columns || archive.rows() != printer.rows) {
    return telling(
        Told(PrinterCode::kArchivePixels, {{PrinterFact::kColumns, archive.columns()},
                                           {PrinterFact::kRows, archive.rows()},
                                           {PrinterFact::kPanelColumns, printer.columns},
                                           {PrinterFact::kPanelRows, printer.rows}}),
        fail(ErrorCode::kDoesNotFit,
             "%s: is sliced for a panel of %u x %u pixels, this printer's has %u x %u.\tSlice it for this printer",
             shown.c_str(), archive.columns(), archive.rows(), printer.columns, printer.rows));
  }
  const double width = printer.columns * double{printer.pitch_x_mm}, depth = printer.rows * double{printer.pitch_y_mm};
  const double its_width = archive.settings().width_mm.value_or(width);
  const double its_depth = archive.settings().depth_mm.value_or(depth);
  // Data sheets round a panel's size. A part that is 1 % too large no longer fits another.
  constexpr double kMostOff = 0.005;
  if (std::abs(its_width / width - 1) > kMostOff || std::abs(its_depth / depth - 1) > kMostOff) {
    return telling(
        Told(PrinterCode::kArchivePanel, {{Fact::kWidthMm, its_width},
                                          {Fact::kDepthMm, its_depth},
                                          {PrinterFact::kPanelWidthMm, width},
                                          {PrinterFact::kPanelDepthMm, depth}}),
        fail(ErrorCode::kDoesNotFit,
             "%s: is sliced for a panel of %.2f x %.2f mm, this printer's has %.2f x %.2f mm.\tSlice it for this "
             "printer",
             shown.c_str(), its_width, its_depth, width, depth));
  }
  return {};
}

Expected<SlicedArchive> check_archive(int file, std::string_view name, const ArchiveTarget& target, Arena& arena,
                                      ProgressSink* progress) {
  auto archive = LayerArchive::open(file, name);
  PLUMBLINE_TRY(archive);
  PLUMBLINE_TRY(check_panel(*archive, name, target.printer));
  SlicedArchive sliced;
  sliced.settings = archive->settings();
  sliced.turn = archive->turn();
  PlacementSettings placement;
  placement.printer = target.printer;
  placement.layer_height_mm = static_cast<float>(sliced.settings.layer_height_mm.value_or(target.layer_height_mm));
  sliced.grid = panel_grid(target.printer, placement.layer_height_mm);
  if (archive->layers() > sliced.grid.layers) {
    return telling(
        Told(PrinterCode::kArchiveHigh, {{Fact::kLayers, archive->layers()},
                                         {Fact::kHeightMm, archive->layers() * double{placement.layer_height_mm}},
                                         {Fact::kLimitMm, target.printer.travel_mm}}),
        fail(ErrorCode::kDoesNotFit,
             "%s: its %u layers of %.4g mm are %.1f mm high, this printer's travel is %.1f mm.\tScale it down and "
             "slice it again",
             PrintableText(name).c_str(), archive->layers(), static_cast<double>(placement.layer_height_mm),
             archive->layers() * static_cast<double>(placement.layer_height_mm),
             static_cast<double>(target.printer.travel_mm)));
  }
  sliced.grid.layers = archive->layers();
  const auto layers = arena.take_bottom<ArchiveLayer>(archive->layers(), "layers");
  PLUMBLINE_TRY(layers);
  sliced.layers_end = arena.bottom_mark();
  PLUMBLINE_TRY(archive->list(*layers));
  PLUMBLINE_TRY(check_layers(*archive, check_limits(placement, target.peel, 0), sliced, *layers, arena, progress));
  sliced.layers = *layers;
  return sliced;
}

PrintProfile profile_of(const PrintProfile& printers, const Sl1Settings& settings, std::string_view name) {
  PrintProfile profile = printers;
  if (settings.first_layer_height_mm) profile.initial_layer_height = *settings.first_layer_height_mm;
  if (settings.exposure_s) profile.exposure_time = *settings.exposure_s;
  if (settings.initial_exposure_s) profile.initial_exposure_time = *settings.initial_exposure_s;
  const bool first_is_longest = profile.initial_exposure_time > profile.exposure_time;
  if (first_is_longest ? settings.initial_exposure_s : settings.exposure_s) profile.exposures_of = name;
  if (settings.faded_layers) profile.faded_layers = *settings.faded_layers;
  // If the bottom layers are to be smaller, the archive's slicer has made them so.
  profile.elefant_foot_compensation = 0;
  return profile;
}

}  // namespace plumbline
