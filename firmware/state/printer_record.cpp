#include "firmware/state/printer_record.hpp"

#include <algorithm>

namespace plumbline::firmware::inline state {

void PrinterRecord::begin_job() {
  job.reset();
  proposals.reset();
  slicing.reset();
  sliced.reset();
  progress.reset();
  resin.reset();
  result.reset();
  note = PrintNote::kNone;
  fault.reset();
  checks = {};
  finding_count = 0;
}

std::optional<std::size_t> PrinterRecord::proposal() const {
  if (!proposals || !job || job->orient) return std::nullopt;
  const std::array<double, 2> turned = {job->rotate_x_deg, job->rotate_y_deg};
  const auto* const found = std::ranges::find(*proposals, turned, &Proposal::degrees);
  if (found == proposals->end()) return std::nullopt;
  return static_cast<std::size_t>(found - proposals->begin());
}

void PrinterRecord::add_finding(Severity severity, std::string_view text, const Told& told, const Remedies& remedies,
                                const IssuePlaces& places) {
  if (finding_count == findings.size()) return;
  FindingRecord& finding = findings[finding_count++];
  finding.severity = severity;
  assign(finding.text, text);
  finding.told = told;
  finding.remedies = remedies;
  finding.places = places;
}

void PrinterRecord::remove_findings(ToldCode which) {
  auto* const end = std::remove_if(findings.begin(), findings.begin() + finding_count,
                                   [which](const FindingRecord& finding) { return finding.told.code == which; });
  finding_count = static_cast<std::size_t>(end - findings.begin());
}

void PrinterRecord::set_progress(const PrintStatus& status, std::int64_t clock_s) {
  using std::chrono::duration_cast;
  using std::chrono::seconds;
  ProgressRecord now;
  now.layers_done = status.layer;
  now.layers = status.layers;
  now.height_mm = status.height.above_film().millimetres();
  now.elapsed = duration_cast<seconds>(status.elapsed);
  now.left = duration_cast<seconds>(status.remaining);
  const bool ends = clock_s != 0 && !is_pause(status.state) && !at_rest(status.state);
  if (ends) now.ends_at = clock_s + now.left.count();
  now.slack = status.slack;
  now.resin_ml = status.resin_ml;
  progress = now;
  state = status.state;
  note = status.note;
  assign(question, status.question);
  question_told = status.question_told;
}

void PrinterRecord::set_fault(FaultCode which, std::string_view finding, std::string_view remedy, const Told& told) {
  fault.emplace();
  fault->code = which;
  assign(fault->message, finding);
  assign(fault->remedy, remedy);
  fault->told = told;
}

}  // namespace plumbline::firmware::inline state
