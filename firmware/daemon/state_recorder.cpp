#include "firmware/daemon/state_recorder.hpp"

#include <ctime>

#include "firmware/print/status/print_lines.hpp"

namespace plumbline {

void StateRecorder::say(const PrintableText& text) {
  assign(record_.message, text.view());
  observer_.say(text);
}

void StateRecorder::look_at_stick() {
  record_.has_stick = stick_.has_stick();
  if (!record_.has_stick) record_.scan_count = record_.scans_left_out = 0;
}

bool StateRecorder::update(const PrintStatus& status) {
  look_at_stick();
  record_.slicing.reset();
  record_.set_progress(status, std::time(nullptr));
  assign(record_.message, status_text(status).view());
  return observer_.update(status);
}

void StateRecorder::checked(Check check, const CheckResult& result) {
  record_.checks[static_cast<std::size_t>(check)] = result;
  observer_.checked(check, result);
}

void StateRecorder::slicing(Stage stage, double fraction) {
  look_at_stick();
  record_.slicing = SlicingRecord{stage, fraction};
  observer_.slicing(stage, fraction);
}

void StateRecorder::printed(const PrintReport& report, const PrintSession& session, const PrintProfile& profile) {
  record_.result = report.state;
  if (report.fault != FaultCode::kNone) {
    record_.set_fault(report.fault, report.fault_message.view(), explain(report.fault, {}).advice.view());
  }
  for_each_warning(report, [this](std::string_view text) { record_.add_finding(Severity::kWarning, text); });
  observer_.printed(report, session, profile);
}

void StateRecorder::idle() {
  look_at_stick();
  observer_.idle();
}

}  // namespace plumbline
