#include "firmware/print/job/sliced_archive.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "firmware/io/mask_hash.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/pictures/job_pictures.hpp"
#include "firmware/pictures/part_model.hpp"
#include "firmware/slice/issue_report.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "slicer/checks/what_matters.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {
namespace {

Status check_layers(LayerArchive& archive, const CheckLimits& limits, bool shows_grey, SlicedArchive& sliced,
                    std::span<ArchiveLayer> layers, Arena& arena, ProgressSink* progress) {
  const PrintGrid& grid = sliced.grid;
  StageMemory memory;
  const StageScope stage(Stage::kLayers, {arena, progress, memory});
  const ArenaScope scratch(arena);
  const std::size_t words = BitImage::words_needed(grid.columns, grid.rows);
  const auto two = arena.take_top<std::uint64_t>(2 * words, "masks");
  PLUMBLINE_TRY(two);
  BitImage mask(two->first(words), grid.columns, grid.rows), below(two->last(words), grid.columns, grid.rows);
  below.clear();
  const auto room = arena.take_top<GreyRun>(shows_grey ? GreyRuns::runs_needed(grid.columns, grid.rows) : 0, "masks");
  PLUMBLINE_TRY(room);
  GreyRuns greys(*room, grid.columns);
  auto checker = StackChecker::create(grid, limits, arena);
  PLUMBLINE_TRY(checker);
  LayerCrossings crossings = LayerCrossings::make(grid, arena);
  for (std::uint32_t layer = 0; layer < grid.layers; ++layer) {
    if (progress != nullptr && !progress->advance(Stage::kLayers, static_cast<double>(layer) / grid.layers)) {
      return fail(ErrorCode::kCancelled, "stopped while the layers were checked, at layer %u of %u", layer,
                  grid.layers);
    }
    PLUMBLINE_TRY(archive.read(layers[layer], mask, &sliced.grey, &greys));
    layers[layer].hash = mask_hash(mask, greys.runs());
    checker->next(mask);
    sliced.extent.hold(mask);
    crossings.next(layer, mask, below);
    std::swap(mask, below);
  }
  sliced.findings = checker->finish();
  find_what_matters(sliced.findings, grid, {});
  sliced.rrep = crossings.rrep(grid);
  return {};
}

}  // namespace

Status check_panel(LayerArchive& archive, std::string_view name, const PrinterVolume& printer) {
  const PrintableText shown = name;
  archive.turn_for(printer.columns, printer.rows);
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
  const ArchiveSettings& said = archive.settings();
  const double its_width = (archive.is_turned() ? said.depth_mm() : said.width_mm()).value_or(width);
  const double its_depth = (archive.is_turned() ? said.width_mm() : said.depth_mm()).value_or(depth);
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
  sliced.turned = archive->is_turned();
  PlacementSettings placement;
  placement.printer = target.printer;
  placement.layer_height_mm =
      static_cast<float>(sliced.settings.value(PrintKey::kLayerHeight).value_or(target.layer_height_mm));
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
  PLUMBLINE_TRY(check_layers(*archive, check_limits(placement, target.peel, 0), target.shows_grey, sliced, *layers,
                             arena, progress));
  sliced.layers = *layers;
  return sliced;
}

void for_each_remark(const SlicedArchive& sliced, FunctionRef<void(const Told&, std::string_view)> visit) {
  if (!sliced.turned) return;
  FixedText<120> text;
  text.add("printed turned by 90 degrees: the archive is sliced for a panel of %u x %u pixels", sliced.grid.rows,
           sliced.grid.columns);
  visit({PrinterCode::kArchiveTurned,
         {{PrinterFact::kColumns, sliced.grid.rows}, {PrinterFact::kRows, sliced.grid.columns}}},
        text.view());
}

Expected<PrintProfile> profile_of(const PrintProfile& printers, const ArchiveSettings& settings, std::string_view name,
                                  const PrintValues& by_person) {
  const auto its = settings.value(PrintKey::kLayerHeight), asked = by_person[index_of(PrintKey::kLayerHeight)];
  if (its && asked && *its != *asked) {
    return fail(ErrorCode::kBadSetting, "%s: its layers are %.6g mm high, so they can't be printed %.6g mm high",
                PrintableText(name).c_str(), *its, *asked);
  }
  PrintProfile profile = printers;
  set_values(profile, settings.values, ValueSource::kArchive);
  profile.archive = name;
  const double whole_lift = profile.lift_height + profile.lift_height2;
  if (profile.retract_height2 > whole_lift) {  // the slow part of the way down is no longer than the way
    set_value(profile, kPrintFields[index_of(PrintKey::kRetractHeight2)], whole_lift, ValueSource::kArchive);
  }
  // If the bottom layers are to be smaller, the archive's slicer has made them so.
  set_value(profile, kPrintFields[index_of(PrintKey::kElefantFootCompensation)], 0, ValueSource::kArchive);
  set_values(profile, by_person, ValueSource::kPerson);
  return profile;
}

LayerCrossings LayerCrossings::make(const PrintGrid& grid, Arena& arena) {
  LayerCrossings all;
  const std::size_t pictures = std::max(preview_picture_bytes(grid), part_model_bytes(grid)) +
                               2 * BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t);
  const auto first = arena.take_bottom<std::uint32_t>(std::size_t{grid.layers} + 1, "preview");
  if (!first || arena.available() <= pictures) return all;
  const auto packed =
      arena.take_bottom<std::uint32_t>((arena.available() - pictures) / sizeof(std::uint32_t), "preview");
  if (!packed) return all;
  all.first_ = *first;
  all.packed_ = *packed;
  all.first_[0] = 0;
  all.fits_ = true;
  return all;
}

void LayerCrossings::next(std::uint32_t layer, ConstBitImage mask, ConstBitImage below) {
  const CrossingPacking packing({.columns = mask.columns(), .rows = mask.rows()});
  for (std::uint32_t r = 0; r < mask.rows() && fits_; ++r) {
    const auto now = mask.row(r);
    const auto before = below.row(r);
    for (std::size_t w = 0; w < now.size(); ++w) {
      for (std::uint64_t rest = now[w] ^ before[w]; rest != 0 && fits_; rest &= rest - 1) {
        fits_ = count_ < packed_.size();
        if (!fits_) break;
        const auto column = static_cast<std::uint32_t>(64 * w) + static_cast<std::uint32_t>(std::countr_zero(rest));
        packed_[count_++] = packing.packed(r * mask.columns() + column);
      }
    }
  }
  if (fits_) first_[layer + 1] = static_cast<std::uint32_t>(count_);
}

RRep LayerCrossings::rrep(const PrintGrid& grid) const {
  if (!fits_) return {};
  return {.grid = grid, .first = first_, .packed = packed_.first(count_), .is_exact = true};
}

}  // namespace plumbline::firmware
