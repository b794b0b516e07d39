#include "firmware/daemon/remedies.hpp"

#include <string_view>

#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

bool is_turned(const JobSettings& job) {
  return job.orient || job.rotate_x_deg != 0 || job.rotate_y_deg != 0 || job.rotate_z_deg != 0;
}

double value_of(const Told& told, Fact fact) {
  for (std::size_t i = 0; i < told.count; ++i) {
    if (told.facts[i] == fact) return told.values[i];
  }
  return 0;
}
double value_of(const Told& told, PrinterFact fact) { return value_of(told, static_cast<Fact>(fact)); }

void stand_up(const Told& told, Remedies& remedies) {
  const double x = value_of(told, Fact::kTurnXDeg), y = value_of(told, Fact::kTurnYDeg);
  if (x != 0 && y != 0) return remedies.add("orient", "auto");
  FixedText<16> degrees;
  degrees.add("%g", x != 0 ? x : y);
  remedies.add(x != 0 ? "rotate_x_deg" : "rotate_y_deg", degrees.view());
}

/// Each unit but the one that the sizes were taken to be in.
void other_units(std::string_view taken, Remedies& remedies) {
  for (const std::string_view unit : kUnitWords) {
    if (unit != taken && unit != "auto") remedies.add("units", unit);
  }
}

}  // namespace

Remedies remedies_of(const Told& finding, const JobSettings& job, bool has_supports) {
  Remedies remedies;
  const std::string_view taken = kUnitWords[static_cast<std::size_t>(job.units)];
  switch (static_cast<PrinterCode>(finding.code)) {
    case PrinterCode::kIsland:
    case PrinterCode::kOverhang:
    case PrinterCode::kFreePiece:
    case PrinterCode::kTear:
    case PrinterCode::kFirstLayerArea:
      if (!has_supports) remedies.add("supports", "auto");
      if (has_supports && !is_turned(job)) remedies.add("orient", "auto");
      break;
    case PrinterCode::kNeedle:
    case PrinterCode::kPeelArea:
    case PrinterCode::kPeelJump:
      if (!is_turned(job)) remedies.add("orient", "auto");
      break;
    case PrinterCode::kLiesWrong:
      if (!is_turned(job)) stand_up(finding, remedies);
      break;
    case PrinterCode::kOnItsFace:
      if (!is_turned(job)) remedies.add("rotate_x_deg", "180");
      break;
    case PrinterCode::kUnitsGuessed:
      if (!job.size) other_units(finding.name(), remedies);
      break;
    case PrinterCode::kObjectSmall:
    case PrinterCode::kObjectLarge:
      if (!job.size && finding.name() == "units") other_units(taken, remedies);
      break;
    case PrinterCode::kFloorCut: remedies.add("floor", "keep"); break;
    case PrinterCode::kPiecesLeftOut:
    case PrinterCode::kSolidsLeftOut:
    case PrinterCode::kCavitiesFilled: remedies.add("keep_all", "true"); break;
    case PrinterCode::kSizeOff: {
      const double asked = value_of(finding, PrinterFact::kAskedMm);
      const double got = value_of(finding, PrinterFact::kDeliveredMm);
      if (!job.size || got <= 0) break;
      FixedText<16> size;
      size.add("%.2fmm", asked * asked / got);
      remedies.add(to_string(job.size->side), size.view());
      break;
    }
    default: break;
  }
  return remedies;
}

IssuePlaces places_of(IssueKind kind, const StackFindings& findings, const PrintGrid& grid) {
  IssuePlaces places;
  if (words_of(kind).size == IssueSize::kLayers) return places;  // it is everywhere
  const IssueScale scale(grid);
  for (const Issue& issue : findings.of(kind).told_kept()) {
    places.mm[places.count++] = {scale.x_mm(issue), scale.y_mm(issue), scale.z_mm(issue.layer)};
  }
  return places;
}

}  // namespace plumbline::firmware
