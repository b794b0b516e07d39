#include "firmware/print/print_report.hpp"

#include <algorithm>

#include "slicer/core/median.hpp"

namespace plumbline {
std::string_view to_string(Check check) {
  switch (check) {
    case Check::kMemory: return "memory";
    case Check::kObject: return "object";
    case Check::kLight: return "light";
    case Check::kLampDark: return "lamp dark";
    case Check::kPanel: return "panel";
    case Check::kCover: return "cover";
    case Check::kTemperatures: return "temperatures";
    case Check::kResin: return "resin";
    case Check::kJournal: return "journal";
    case Check::kStage: return "stage";
  }
  return "unknown check";
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

void for_each_warning(const PrintReport& report, const std::function<void(std::string_view)>& tell) {
  FixedText<320> text;
  const auto say = [&text, &tell] {
    tell(text.view());
    text.clear();
  };
  if (report.marked_layer) {
    text.add("the print went on at layer %u after it had been interrupted: that layer may show a mark",
             *report.marked_layer);
    say();
  }
  if (report.late_masks > 0) {
    text.add("%u masks were late: those exposures began later, none was shorter", report.late_masks);
    say();
  }
  if (report.doses_off > 0) {
    text.add("%u exposures were more than 1 %% off their dose: have the lamp measured", report.doses_off);
    say();
  }
  constexpr Distance kNoticed = Distance::nanometres(10'000);
  if (report.steps_lost > kNoticed || -report.steps_lost > kNoticed) {
    text.add("PL-%u: the stage had lost %.3f mm when it came back to its end stop: the part may have a step",
             static_cast<unsigned>(FaultCode::kStepsLost), report.steps_lost.millimetres());
    say();
  }
  if (report.exposures_untold > 0) {
    text.add("%u exposures more than the report has room for", report.exposures_untold);
    say();
  }
}

}  // namespace plumbline
