#include "firmware/print/print_summary.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/io/random_id.hpp"
#include "firmware/print/status/print_lines.hpp"
#include "firmware/slice/issue_report.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline {
namespace {

double seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }
double milliseconds(nanoseconds time) { return std::chrono::duration<double, std::milli>(time).count(); }

const char* word_of(ExposureEnd end) {
  switch (end) {
    case ExposureEnd::kTimeUp: return "time up";
    case ExposureEnd::kStopped: return "stopped";
    case ExposureEnd::kCoverOpened: return "cover opened";
  }
  return "unknown";
}

using Text = FixedText<4096>;

void add_fault(Text& text, const PrintReport& report) {
  if (report.fault == FaultCode::kNone) return;
  const FaultText fault = explain(report.fault, report.fault_message.view());
  text.add("fault      %s\n           %s\n", fault.what.c_str(), fault.advice.c_str());
}

void add_doses(Text& text, const PrintReport& report) {
  if (report.exposures.empty()) return;
  double worst = 0;
  bool measured = true;
  for (const auto& line : report.exposures) {
    measured = measured && line.source == DoseSource::kMeasured;
    if (line.end != ExposureEnd::kTimeUp || !(line.expected.value() > 0)) continue;
    const double off = line.dose / line.expected - 1;
    worst = std::abs(off) > std::abs(worst) ? off : worst;
  }
  text.add("doses      %zu exposure%s, %s; the worst is %+.2f %% off\n", report.exposures.size(),
           plural_s(report.exposures.size()), measured ? "measured" : "computed", 100 * worst);
}

void add_masks(Text& text, const MaskFigures& masks) {
  if (masks.masks == 0) return;
  text.add(
      "masks      rendered while the layer below cured: median %.2f ms (%.1f times the copying of their bytes), worst "
      "%.2f ms; smallest slack %.3f s, under layer %u\n",
      milliseconds(masks.median_making), masks.ratio(), milliseconds(masks.worst_making), seconds(masks.smallest_slack),
      masks.smallest_slack_layer + 1);
}

void add_steps(Text& text, const StepFigures& steps) {
  text.add(
      "stage      %llu steps, %llu late, the worst by %.2f ms; the motor stopped %llu time%s. Real-time priority: %s, "
      "locked memory: %s\n",
      static_cast<unsigned long long>(steps.steps), static_cast<unsigned long long>(steps.late),
      milliseconds(steps.worst_lateness), static_cast<unsigned long long>(steps.standstills),
      plural_s(steps.standstills), steps.real_time ? "yes" : "no", steps.memory_locked ? "yes" : "no");
}

void add_print(Text& text, const PrintOutcome& outcome) {
  const PrintReport& report = outcome.report;
  const auto state = to_string(report.state);
  const PrintableText scan = view(outcome.session.facts().scan);
  text.add("print      %s: %.*s, %u of %u layers, %.2f mm\n", scan.c_str(), static_cast<int>(state.size()),
           state.data(), report.next_layer, report.layers,
           report.next_layer > 0 ? height_of(outcome.session.plan(), report.next_layer - 1).above_film().millimetres()
                                 : 0.0);
  add_fault(text, report);
  text.add("time       %s, %s estimated", duration_text(report.elapsed).c_str(),
           duration_text(report.estimated).c_str());
  if (report.pauses > 0) text.add(", paused %u time%s", report.pauses, plural_s(report.pauses));
  text.add("\n");
  if (!outcome.session.supports().empty()) text.add("supports   %u\n", outcome.session.supports().tips());
  text.add("resin      %s ml", three_digits(report.resin_ml).c_str());
  const double cost = resin_cost(outcome.profile, report.resin_ml);
  if (cost > 0) text.add(", cost %.2f (in the currency of bottle_cost)", cost);
  text.add("\n");
}

void add_details(Text& text, const PrintOutcome& outcome) {
  const PrintReport& report = outcome.report;
  if (report.slowest.count() > 0) {
    text.add("slowest    layer %u, %.2f s\n", report.slowest_layer + 1, seconds(report.slowest));
  }
  add_doses(text, report);
  add_masks(text, outcome.session.mask_figures());
  if (outcome.steps) add_steps(text, *outcome.steps);
}

/// What a maker would look at; less than a drop is not worth a line.
void add_part(Text& text, const PartFigures& part) {
  constexpr double kDropMl = 0.05;
  const bool trapped = part.trapped_ml >= kDropMl;
  const bool sucks = part.suction_cm2 >= 0.1;
  if (part.lost.empty() && !trapped && !sucks) return;
  text.add("part       %.3g ml lost, peeled with at most %.1f N", part.lost_ml(), part.largest_peel_n);
  if (sucks) text.add(", suction cups of %.1f cm2", part.suction_cm2);
  if (trapped) text.add(", %.1f ml of resin trapped", part.trapped_ml);
  text.add("\n");
}

Status write_objections(OutputFile& out, std::span<const std::string> objections) {
  Text text;
  if (objections.empty()) return out.write(std::string_view("simulated  no objections\n"));
  text.add("simulated  %zu objection%s:\n", objections.size(), plural_s(objections.size()));
  PLUMBLINE_TRY(out.write(text.view()));
  for (const auto& objection : objections) {
    text.clear();
    text.add("           %s\n", objection.c_str());
    PLUMBLINE_TRY(out.write(text.view()));
  }
  return {};
}

void write_part(JsonWriter& json, const PartFigures& part) {
  json.begin_object();
  json.member("lost_ml", thousandths(part.lost_ml()));
  json.member("trapped_ml", thousandths(part.trapped_ml));
  json.member("traps", part.traps);
  json.member("bleed_ml", thousandths(part.bleed_ml));
  json.member("largest_peel_n", thousandths(part.largest_peel_n));
  json.member("largest_suction_cm2", thousandths(part.suction_cm2));
  json.key("lost");
  json.begin_array();
  for (const LostPiece& piece : part.lost) {
    json.begin_object(kOneLine);
    json.member("kind", piece.kind);
    json.member("layer", piece.layer);
    json.member("last_layer", piece.last_layer);
    json.member("x_mm", thousandths(piece.x_mm));
    json.member("y_mm", thousandths(piece.y_mm));
    json.member("ml", piece.ml);
    json.end_object();
  }
  json.end_array();
  json.end_object();
}

void write_fault(JsonWriter& json, const PrintReport& report) {
  if (report.fault == FaultCode::kNone) return json.null();
  const FaultText text = explain(report.fault, report.fault_message.view());
  FixedText<16> code;
  code.add("PL-%u", static_cast<unsigned>(report.fault));
  json.begin_object();
  json.member("code", code.view());
  json.member("title", info(report.fault).title);
  json.member("message", report.fault_message.view());
  json.member("next", text.advice.view());
  json.end_object();
}

void write_checks(JsonWriter& json, const PrintReport& report) {
  json.begin_array();
  for (std::size_t i = 0; i < kCheckCount; ++i) {
    json.begin_object(kOneLine);
    json.member("check", to_string(static_cast<Check>(i)));
    json.member("outcome", to_string(report.checks[i].outcome));
    json.member("detail", report.checks[i].detail.view());
    json.end_object();
  }
  json.end_array();
}

void write_masks(JsonWriter& json, const MaskFigures& masks) {
  json.begin_object();
  json.member("smallest_slack_s", seconds(masks.smallest_slack));
  json.member("smallest_slack_layer", masks.smallest_slack_layer);
  json.member("median_ms", thousandths(milliseconds(masks.median_making)));
  json.member("worst_ms", thousandths(milliseconds(masks.worst_making)));
  json.member("copy_ms", thousandths(milliseconds(masks.median_copying)));
  json.member("ratio_to_copy", thousandths(masks.ratio()));
  json.end_object();
}

void write_steps(JsonWriter& json, const std::optional<StepFigures>& steps) {
  if (!steps) return json.null();
  json.begin_object();
  json.member("steps", steps->steps);
  json.member("late_steps", steps->late);
  json.member("worst_lateness_ms", milliseconds(steps->worst_lateness));
  json.member("standstills", steps->standstills);
  json.member("real_time_priority", steps->real_time);
  json.member("locked_memory", steps->memory_locked);
  json.end_object();
}

void write_exposures(JsonWriter& json, const PrintReport& report) {
  json.begin_array();
  for (const auto& line : report.exposures) {
    json.begin_object(kOneLine);
    json.member("layer", line.layer);
    json.member("asked_s", seconds(line.asked));
    json.member("lit_s", seconds(line.lit));
    json.member("dose_mj_cm2", thousandths(line.dose.value()));
    json.member("expected_mj_cm2", thousandths(line.expected.value()));
    json.member("end", word_of(line.end));
    json.key("mask_hash");
    json.hex(line.mask_hash);
    json.end_object();
  }
  json.end_array();
}

}  // namespace

Status write_print_summary(OutputFile& out, const PrintOutcome& outcome, std::string_view look_at, bool verbose) {
  Text text;
  add_print(text, outcome);
  if (verbose) add_details(text, outcome);
  PLUMBLINE_TRY(out.write(text.view()));
  Status written;
  for_each_warning(outcome.report, [&](const Told&, std::string_view warning) {
    Text line;
    line.add("warning    %.*s\n", static_cast<int>(warning.size()), warning.data());
    if (written) written = out.write(line.view());
  });
  if (const auto& findings = outcome.session.findings()) {
    for_each_issue(*findings, outcome.session.grid(), outcome.profile.checks,
                   [&](IssueKind, CheckAction, std::string_view sentence) {
                     Text line;
                     line.add("issue      %.*s\n", static_cast<int>(sentence.size()), sentence.data());
                     if (written) written = out.write(line.view());
                   });
  }
  PLUMBLINE_TRY(written);
  if (outcome.part) {
    text.clear();
    add_part(text, *outcome.part);
    PLUMBLINE_TRY(out.write(text.view()));
    PLUMBLINE_TRY(write_objections(out, outcome.objections));
  }
  if (look_at.empty()) return {};
  text.clear();
  text.add("look at    %.*s\n", static_cast<int>(look_at.size()), look_at.data());
  return out.write(text.view());
}

void write_print_report(JsonWriter& json, const PrintOutcome& outcome) {
  const PrintReport& report = outcome.report;
  const JobFacts& facts = outcome.session.facts();
  json.begin_object();
  json.member("id", id_text(facts.print_id).view());
  json.member("scan", view(facts.scan));
  if (const auto files = outcome.session.scan_files(); files.size() > 1) {
    json.key("files");
    json.begin_array(kOneLine);
    for (const auto& file : files) json.value(view(file));
    json.end_array();
  }
  json.member("printer", view(facts.printer));
  json.member("profile", view(facts.profile));
  json.member("state", to_string(report.state));
  json.key("fault");
  write_fault(json, report);
  json.key("checks");
  write_checks(json, report);
  json.member("layers", report.layers);
  json.member("first_layer", report.first_layer);
  json.member("next_layer", report.next_layer);
  json.member("layer_height_mm", facts.contract.plan.layer_height.millimetres());
  json.key("contract");
  json.begin_object();
  write_contract(json, facts.contract);
  json.end_object();
  json.member("supports", std::uint64_t{outcome.session.supports().tips()});
  if (const auto& findings = outcome.session.findings()) {
    write_issues(json, *findings, outcome.session.grid(), outcome.profile.checks);
  } else {
    json.key("issues");
    json.null();
  }
  json.member("resin_ml", thousandths(report.resin_ml));
  json.member("resin_needed_ml", thousandths(outcome.session.needed_ml()));
  json.member("cost", thousandths(resin_cost(outcome.profile, report.resin_ml)));
  json.member("elapsed_s", seconds(report.elapsed));
  json.member("estimated_s", seconds(report.estimated));
  json.member("slowest_layer", report.slowest_layer);
  json.member("slowest_layer_s", seconds(report.slowest));
  json.member("pauses", report.pauses);
  json.member("late_masks", report.late_masks);
  json.key("masks");
  write_masks(json, outcome.session.mask_figures());
  json.key("stage");
  write_steps(json, outcome.steps);
  json.key("warnings");
  json.begin_array();
  for_each_warning(report, [&json](const Told&, std::string_view warning) { json.value(warning); });
  json.end_array();
  json.key("objections");
  if (outcome.part) {
    json.begin_array();
    for (const auto& objection : outcome.objections) json.value(std::string_view(objection));
    json.end_array();
  } else {
    json.null();
  }
  json.key("part");
  if (outcome.part) {
    write_part(json, *outcome.part);
  } else {
    json.null();
  }
  json.key("exposures");
  write_exposures(json, report);
  json.end_object();
}

}  // namespace plumbline
