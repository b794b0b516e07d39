#include "firmware/print/print_summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/io/progress_lines.hpp"
#include "firmware/io/random_id.hpp"
#include "firmware/io/text/json_fields.hpp"
#include "firmware/slice/issue_report.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline::firmware {
namespace {

double seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }
double milliseconds(nanoseconds time) { return std::chrono::duration<double, std::milli>(time).count(); }

/// By ExposureEnd.
constexpr std::array<std::string_view, 3> kEndWords = {"time up", "stopped", "cover opened"};

using Layout = JsonWriter::Layout;
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
  const PrintableText scan = view(outcome.session.printable().facts.scan);
  text.add("print      %s: %.*s, %u of %u layers, %.2f mm\n", scan.c_str(), static_cast<int>(state.size()),
           state.data(), report.next_layer, report.layers,
           report.next_layer > 0 ? height_of(outcome.session.plan(), report.next_layer - 1).above_film().millimetres()
                                 : 0.0);
  add_fault(text, report);
  text.add("time       %s, %s estimated", duration_text(report.elapsed).c_str(),
           duration_text(report.estimated).c_str());
  if (report.pauses > 0) text.add(", paused %u time%s", report.pauses, plural_s(report.pauses));
  text.add("\n");
  if (!outcome.session.printable().parts.supports.empty())
    text.add("supports   %u\n", outcome.session.printable().parts.supports.tips());
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

/// The part's deviation, in whole micrometres.
void add_deviation(Text& text, const DeviationFigures& from) {
  text.add("deviation  %.0f um RMS from %s", from.rms, from.against.c_str());
  const auto add = [&text](const char* what, double mean, double rms) {
    if (std::isfinite(mean)) text.add(", %s %+ld um (%.0f um RMS about it)", what, std::lround(mean), rms);
  };
  add("undersides", from.down_mean, from.down_rms);
  add("walls", from.wall_mean, from.wall_rms);
  if (std::isfinite(from.top_rms)) text.add(", tops %.0f um RMS", from.top_rms);
  const auto missing = static_cast<double>(from.missing) / static_cast<double>(std::max<std::uint64_t>(from.points, 1));
  if (from.missing > 0) text.add("; %.2g %% of the surface missing", 100 * missing);
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

/// JsonField::write of a time, in milliseconds.
template <auto of, class T>
void in_ms(JsonWriter& json, const T& from) {
  json.value(thousandths(milliseconds(from.*of)));
}

constexpr JsonField<LostPiece> kLostFields[] = {
    {"kind", member<&LostPiece::kind>},
    {"layer", member<&LostPiece::layer>},
    {"last_layer", member<&LostPiece::last_layer>},
    {"x_mm", rounded<&LostPiece::x_mm>},
    {"y_mm", rounded<&LostPiece::y_mm>},
    {"ml", member<&LostPiece::ml>},
};

constexpr JsonField<DeviationFigures> kDeviationFields[] = {
    {"against", member<&DeviationFigures::against>},    {"points", member<&DeviationFigures::points>},
    {"missing", member<&DeviationFigures::missing>},    {"sealed", member<&DeviationFigures::sealed>},
    {"rms", rounded<&DeviationFigures::rms>},           {"down_mean", rounded<&DeviationFigures::down_mean>},
    {"down_rms", rounded<&DeviationFigures::down_rms>}, {"wall_mean", rounded<&DeviationFigures::wall_mean>},
    {"wall_rms", rounded<&DeviationFigures::wall_rms>}, {"top_rms", rounded<&DeviationFigures::top_rms>},
};

constexpr JsonField<PartFigures> kPartFields[] = {
    {"lost_ml", rounded<&PartFigures::lost_ml>},
    {"trapped_ml", rounded<&PartFigures::trapped_ml>},
    {"traps", member<&PartFigures::traps>},
    {"bleed_ml", rounded<&PartFigures::bleed_ml>},
    {"largest_peel_n", rounded<&PartFigures::largest_peel_n>},
    {"largest_suction_cm2", rounded<&PartFigures::suction_cm2>},
    {"deviation_um", object<&PartFigures::deviation, kDeviationFields>},
    {"lost", [](auto& json, auto& part) { write_objects(json, kLostFields, part.lost, Layout::kLines); }},
};

void write_fault(JsonWriter& json, const PrintReport& report) {
  if (report.fault == FaultCode::kNone) return json.null();
  json.begin_object();
  json.member("code", report.fault);
  json.member("title", info(report.fault).title);
  json.member("message", report.fault_message);
  json.member("next", explain(report.fault, {}).advice);
  json.end_object();
}

void write_checks(JsonWriter& json, const PrintReport& report) {
  json.begin_array();
  for (std::size_t i = 0; i < kCheckCount; ++i) {
    json.begin_object(kOneLine);
    json.member("check", static_cast<Check>(i));
    json.member("outcome", report.checks[i].outcome);
    json.member("detail", report.checks[i].detail);
    json.end_object();
  }
  json.end_array();
}

constexpr JsonField<MaskFigures> kMaskFields[] = {
    {"smallest_slack_s", member<&MaskFigures::smallest_slack>},
    {"smallest_slack_layer", member<&MaskFigures::smallest_slack_layer>},
    {"median_ms", in_ms<&MaskFigures::median_making>},
    {"worst_ms", in_ms<&MaskFigures::worst_making>},
    {"copy_ms", in_ms<&MaskFigures::median_copying>},
    {"ratio_to_copy", rounded<&MaskFigures::ratio>},
};

constexpr JsonField<StepFigures> kStepFields[] = {
    {"steps", member<&StepFigures::steps>},
    {"late_steps", member<&StepFigures::late>},
    {"worst_lateness_ms", [](auto& json, auto& steps) { json.value(milliseconds(steps.worst_lateness)); }},
    {"standstills", member<&StepFigures::standstills>},
    {"real_time_priority", member<&StepFigures::real_time>},
    {"locked_memory", member<&StepFigures::memory_locked>},
};

constexpr JsonField<ExposureLine> kExposureFields[] = {
    {"layer", member<&ExposureLine::layer>},
    {"exposure", member<&ExposureLine::exposure>},
    {"asked_s", member<&ExposureLine::asked>},
    {"lit_s", member<&ExposureLine::lit>},
    {"dose_mj_cm2", [](auto& json, auto& line) { json.value(thousandths(line.dose.value())); }},
    {"expected_mj_cm2", [](auto& json, auto& line) { json.value(thousandths(line.expected.value())); }},
    {"end", [](auto& json, auto& line) { json.value(kEndWords[static_cast<std::size_t>(line.end)]); }},
    {"mask_hash", [](auto& json, auto& line) { json.hex(line.mask_hash); }},
};

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
  if (const auto& findings = outcome.session.printable().findings) {
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
    if (outcome.part->deviation) add_deviation(text, *outcome.part->deviation);
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
  const PrintSession& session = outcome.session;
  const JobFacts& facts = session.printable().facts;
  json.begin_object();
  json.member("id", id_text(facts.print_id));
  json.member("scan", view(facts.scan));
  if (const auto files = session.printable().facts.scan_files(); files.size() > 1) {
    json.begin_array("files", kOneLine);
    for (const auto& file : files) json.value(view(file));
    json.end_array();
  }
  json.member("printer", view(facts.printer));
  json.member("profile", view(facts.profile));
  json.member("state", report.state);
  json.key("fault");
  write_fault(json, report);
  json.key("checks");
  write_checks(json, report);
  json.member("layers", report.layers);
  json.member("first_layer", report.first_layer);
  json.member("next_layer", report.next_layer);
  json.member("layer_height_mm", facts.contract.plan.layer_height.millimetres());
  json.begin_object("contract");
  write_contract(json, facts.contract);
  json.end_object();
  json.member("supports", session.printable().parts.supports.tips());
  write_issues(json, session.printable().findings, session.grid(), outcome.profile.checks);
  json.member("resin_ml", thousandths(report.resin_ml));
  json.member("resin_needed_ml", thousandths(session.needed_ml()));
  json.member("cost", thousandths(resin_cost(outcome.profile, report.resin_ml)));
  json.member("elapsed_s", report.elapsed);
  json.member("estimated_s", report.estimated);
  json.member("slowest_layer", report.slowest_layer);
  json.member("slowest_layer_s", report.slowest);
  json.member("pauses", report.pauses);
  json.member("late_masks", report.late_masks);
  json.key("masks");
  write_object(json, kMaskFields, session.mask_figures(), Layout::kLines);
  json.key("stage");
  write_object(json, kStepFields, outcome.steps, Layout::kLines);
  json.begin_array("warnings");
  for_each_warning(report, [&json](const Told&, std::string_view warning) { json.value(warning); });
  json.end_array();
  json.key("objections");
  if (outcome.part) {
    json.begin_array();
    for (const auto& objection : outcome.objections) json.value(objection);
    json.end_array();
  } else {
    json.null();
  }
  json.key("part");
  write_object(json, kPartFields, outcome.part, Layout::kLines);
  json.key("exposures");
  write_objects(json, kExposureFields, report.exposures, Layout::kLines);
  json.end_object();
}

}  // namespace plumbline::firmware
