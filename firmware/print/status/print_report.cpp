#include "firmware/print/status/print_report.hpp"

#include <algorithm>

#include "firmware/messages/printer_code.hpp"
#include "slicer/core/numbers/median.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline::firmware {

void PrintReport::add(const ExposureLine& exposure) {
  if (exposures.size() == room.size()) {
    ++exposures_left_out;
    return;
  }
  room[exposures.size()] = exposure;
  exposures = room.first(exposures.size() + 1);
}

MaskFigures mask_figures(std::span<const ExposureLine> exposures, std::span<nanoseconds> scratch) {
  MaskFigures figures;
  std::size_t count = 0;
  for (const auto& line : exposures) {
    if (!line.next_made) continue;
    if (count == 0 || line.slack < figures.smallest_slack) {
      figures.smallest_slack = line.slack;
      figures.smallest_slack_layer = line.layer;
    }
    figures.worst_making = std::max(figures.worst_making, line.making);
    scratch[count++] = line.making;
  }
  figures.masks = static_cast<std::uint32_t>(count);
  if (count == 0) return figures;
  figures.median_making = median(scratch.first(count));
  count = 0;
  for (const auto& line : exposures) {
    if (line.next_made) scratch[count++] = line.copying;
  }
  figures.median_copying = median(scratch.first(count));
  return figures;
}

void for_each_warning(const PrintReport& report, const std::function<void(const Told&, std::string_view)>& tell) {
  FixedText<320> text;
  const auto say = [&text, &tell](const Told& told) {
    tell(told, text.view());
    text.clear();
  };
  if (report.marked_layer) {
    text.add("the print was interrupted before layer %u, which may show a mark", *report.marked_layer + 1);
    say({PrinterCode::kMayShowMark, {{Fact::kLayer, *report.marked_layer + 1.0}}});
  }
  if (report.late_masks > 0) {
    text.add("%u mask%s late; the exposures waited for them and are whole", report.late_masks,
             report.late_masks == 1 ? " was" : "s were");
    say({PrinterCode::kMasksLate, {{Fact::kCount, report.late_masks}}});
  }
  if (report.doses_off > 0) {
    text.add("%u exposure%s more than 1 %% off in dose: have the lamp measured", report.doses_off,
             report.doses_off == 1 ? " was" : "s were");
    say({PrinterCode::kDosesOff, {{Fact::kCount, report.doses_off}}});
  }
  // Ten microns: below any layer height, above the repeatability of homing.
  constexpr Distance kNoticed = Distance::micrometres(10);
  if (report.steps_lost > kNoticed || -report.steps_lost > kNoticed) {
    text.add("PL-%u: the Z stage was %.3f mm off when it came back to its end stop, so the part may have a step",
             static_cast<unsigned>(FaultCode::kStepsLost), report.steps_lost.millimetres());
    say({PrinterCode::kStepsLost, {{PrinterFact::kOffMm, report.steps_lost.millimetres()}}});
  }
  if (report.exposures_left_out > 0) {
    text.add("the report has no room for %u more exposure%s", report.exposures_left_out,
             plural_s(report.exposures_left_out));
    say({PrinterCode::kReportFull, {{Fact::kCount, report.exposures_left_out}}});
  }
}

}  // namespace plumbline::firmware
