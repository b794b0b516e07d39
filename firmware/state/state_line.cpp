#include "firmware/state/state_line.hpp"

#include <ctime>

#include "firmware/io/random_id.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/io/version.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/state/command_rules.hpp"

namespace plumbline {
namespace {

double seconds_of(nanoseconds time) { return thousandths(std::chrono::duration<double>(time).count()); }

/// `value`, or none where `there` is false.
template <class T>
std::optional<T> only_if(bool there, T value) {
  return there ? std::optional(value) : std::nullopt;
}

/// What `map` makes of a value; none of none.
template <class T, class Map>
auto mapped(const std::optional<T>& value, Map map) {
  return value ? std::optional(map(*value)) : std::nullopt;
}

void text_or_null(JsonWriter& json, std::string_view name, std::string_view text) {
  json.member(name, only_if(!text.empty(), text));
}

void id_or_null(JsonWriter& json, std::string_view name, std::uint64_t id) {
  json.member(name, only_if(id != 0, id_text(id).view()));
}

/// "2026-11-25T22:10:05Z"; null for 0.
void write_time(JsonWriter& json, std::string_view name, std::int64_t seconds) {
  json.key(name);
  const auto time = static_cast<std::time_t>(seconds);
  std::tm parts{};
  if (seconds == 0 || ::gmtime_r(&time, &parts) == nullptr) return json.null();
  FixedText<64> text;
  text.add("%04d-%02d-%02dT%02d:%02d:%02dZ", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday, parts.tm_hour,
           parts.tm_min, parts.tm_sec);
  json.value(text.view());
}

void write_stick(JsonWriter& json, const PrinterRecord& record) {
  json.begin_object(kOneLine);
  json.member("present", record.has_stick);
  json.member("job_file", record.has_job_file);
  text_or_null(json, "folder", record.folder.view());
  json.key("scans");
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < record.scan_count; ++i) {
    const ScanRecord& scan = record.scans[i];
    json.begin_object(kOneLine);
    json.member("number", static_cast<std::uint32_t>(i + 1));
    json.member("name", scan.name.view());
    json.member("files", scan.files);
    json.member("bytes", scan.bytes);
    text_or_null(json, "problem", scan.problem.view());
    write_told(json, "told", scan.told);
    json.member("picture", only_if(scan.picture > 0, scan.picture));
    json.end_object();
  }
  json.end_array();
  json.key("folders");
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < record.folder_count; ++i) {
    json.begin_object(kOneLine);
    json.member("number", static_cast<std::uint32_t>(i + 1));
    json.member("name", record.folders[i].name.view());
    json.member("entries", record.folders[i].entries);
    json.end_object();
  }
  json.end_array();
  const LeftOutRecord& left_out = record.left_out;
  json.member("left_out", static_cast<std::uint64_t>(left_out.files));
  json.member("folders_left_out", static_cast<std::uint64_t>(left_out.folders));
  json.member("partitions_left_out", static_cast<std::uint64_t>(left_out.partitions));
  text_or_null(json, "not_listed", left_out.text.view());
  write_told(json, "not_listed_told", left_out.told);
  json.member("uploaded", record.scans_uploaded);
  json.end_object();
}

std::string_view word_of(UploadRecord::Stage stage) {
  switch (stage) {
    case UploadRecord::Stage::kComing: return "coming";
    case UploadRecord::Stage::kKept: return "kept";
    case UploadRecord::Stage::kFailed: return "failed";
  }
  return "failed";
}

void write_upload(JsonWriter& json, const PrinterRecord& record) {
  if (!record.upload) return json.null();
  const UploadRecord& upload = *record.upload;
  json.begin_object(kOneLine);
  json.member("number", upload.number);
  json.member("stage", word_of(upload.stage));
  json.member("name", upload.name.view());
  json.member("bytes", upload.bytes);
  json.member("received", upload.received);
  text_or_null(json, "problem", upload.problem.view());
  write_told(json, "told", upload.told);
  json.end_object();
}

void write_stored(JsonWriter& json, const PrinterRecord& record) {
  if (!record.stored) return json.null();
  json.begin_object(kOneLine);
  json.member("name", record.stored->name.view());
  json.member("bytes", record.stored->bytes);
  json.end_object();
}

std::string_view word_of(BaseChoice base) {
  switch (base) {
    case BaseChoice::kAuto: return "auto";
    case BaseChoice::kNone: return "none";
    case BaseChoice::kFlat: return "flat";
  }
  return "auto";
}

void write_job(JsonWriter& json, const PrinterRecord& record) {
  if (!record.job) return json.null();
  const JobRecord& job = *record.job;
  json.begin_object(kOneLine);
  id_or_null(json, "id", record.job_id);
  json.member("scan", job.scan.view());
  json.key("files");
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < job.file_count; ++i) json.value(job.files[i].view());
  json.end_array();
  json.member("number", mapped(job.chosen, [](auto i) { return static_cast<std::uint32_t>(i + 1); }));
  json.member("profile", job.profile.view());
  json.member("units", to_string(job.units));
  json.member("scale", job.scale);
  json.member("fit", job.fit);
  json.key("size");
  if (job.size) {
    json.begin_object(kOneLine);
    json.member("side", to_string(job.size->side));
    json.member("mm", job.size->mm);
    json.end_object();
  } else {
    json.null();
  }
  json.member("orient", job.orient ? "auto" : "none");
  json.key("floor");
  if (job.floor.kind == FloorChoice::Kind::kHeight) {
    json.value(job.floor.height);
  } else {
    json.value(job.floor.kind == FloorChoice::Kind::kAuto ? "auto" : "keep");
  }
  json.member("rotate_x_deg", job.rotate_x_deg);
  json.member("rotate_y_deg", job.rotate_y_deg);
  json.member("rotate_z_deg", job.rotate_z_deg);
  json.member("layer_height", only_if(job.layer_height > 0, job.layer_height));
  json.member("supports", mapped(job.supports, [](bool wanted) { return wanted ? "auto" : "none"; }));
  json.member("proposal", mapped(record.proposal(), [](auto i) { return static_cast<std::uint32_t>(i); }));
  json.member("as", to_string(job.as));
  json.member("base", word_of(job.base));
  json.member("keep_all", job.keep_all);
  json.key("values");
  json.begin_object(kOneLine);
  for (const PrintField& field : kPrintFields) {
    if (const auto value = job.values[index_of(field.key)]) json.member(field.name, *value);
  }
  json.end_object();
  json.member("result", mapped(record.result, [](PrintState state) { return to_string(state); }));
  json.end_object();
}

void write_proposals(JsonWriter& json, const PrinterRecord& record) {
  if (!record.proposals) return json.null();
  json.begin_array(kOneLine);
  for (std::uint32_t number = 0; const Proposal& way : *record.proposals) {
    json.begin_object(kOneLine);
    json.member("number", number++);
    json.member("rotate_x_deg", way.degrees[0]);
    json.member("rotate_y_deg", way.degrees[1]);
    json.member("support_mm2", thousandths(way.support_mm2));
    json.member("support_ml", thousandths(way.support_mm3 / 1000));
    json.member("peel_mm2", thousandths(way.peel_mm2));
    json.member("height_mm", thousandths(way.height_mm));
    json.member("scar_mm2", thousandths(way.scar_mm2));
    json.end_object();
  }
  json.end_array();
}

void write_profiles(JsonWriter& json, const PrinterRecord& record) {
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < record.profile_count; ++i) json.value(record.profiles[i].view());
  json.end_array();
}

void write_sliced(JsonWriter& json, const PrinterRecord& record) {
  if (!record.sliced) return json.null();
  const Contract& sliced = *record.sliced;
  json.begin_object(kOneLine);
  json.member("layer_height_mm", thousandths(sliced.plan.layer_height.millimetres()));
  json.member("layers", sliced.plan.layers);
  write_contract(json, sliced);
  json.end_object();
}

/// The number of a picture, which rises when there is another one; null: there is none.
void write_pictures(JsonWriter& json, const PrinterRecord& record) {
  const JobPictures* const pictures = record.pictures;
  const auto number = [&](std::string_view name, bool there, std::uint32_t value) {
    json.member(name, only_if(there, value));
  };
  json.begin_object(kOneLine);
  number("preview", pictures != nullptr && pictures->preview.there(),
         pictures != nullptr ? pictures->preview_number : 0);
  number("issues", pictures != nullptr && pictures->issues.there(), pictures != nullptr ? pictures->issues_number : 0);
  number("coverage", pictures != nullptr && pictures->coverage.there(),
         pictures != nullptr ? pictures->coverage_number : 0);
  number("layer", pictures != nullptr && pictures->layer().there(), pictures != nullptr ? pictures->layer_number : 0);
  number("side", pictures != nullptr && pictures->sides[0].there(), pictures != nullptr ? pictures->side_number : 0);
  number("proposal", pictures != nullptr && pictures->proposals[0].there(),
         pictures != nullptr ? pictures->proposal_number : 0);
  json.end_object();
}

void write_slicing(JsonWriter& json, const PrinterRecord& record) {
  if (!record.slicing) return json.null();
  json.begin_object(kOneLine);
  json.member("stage", to_string(record.slicing->stage));
  json.member("fraction", thousandths(record.slicing->fraction));
  json.member("proposes", record.slicing->proposes);
  json.end_object();
}

void write_progress(JsonWriter& json, const PrinterRecord& record) {
  if (!record.progress) return json.null();
  const ProgressRecord& progress = *record.progress;
  json.begin_object(kOneLine);
  json.member("layers_done", progress.layers_done);
  json.member("layers", progress.layers);
  json.member("height_mm", thousandths(progress.height_mm));
  json.member("elapsed_s", static_cast<std::uint64_t>(progress.elapsed.count()));
  json.member("left_s", static_cast<std::uint64_t>(progress.left.count()));
  write_time(json, "ends_at", progress.ends_at);
  json.member("slack_s", mapped(progress.slack, seconds_of));
  json.end_object();
}

void write_prints(JsonWriter& json, const PrinterRecord& record) {
  json.begin_array(kOneLine);
  const auto prints = record.prints != nullptr ? record.prints->list() : std::span<const KeptPrint>();
  for (const KeptPrint& print : prints) {
    json.begin_object(kOneLine);
    json.member("number", print.number);
    json.member("scan", view(print.scan));
    json.member("profile", view(print.profile));
    json.member("result", to_string(static_cast<PrintState>(print.result)));
    json.member("layers_done", print.layers_done);
    json.member("layers", print.layers);
    json.member("resin_ml", thousandths(print.resin_ml));
    write_time(json, "ended_at", print.ended_at);
    json.member("preview", print.preview_bytes > 0);
    json.end_object();
  }
  json.end_array();
}

void write_resin(JsonWriter& json, const PrinterRecord& record) {
  if (!record.resin) return json.null();
  json.begin_object(kOneLine);
  json.member("used_ml", thousandths(record.progress ? record.progress->resin_ml : 0));
  json.member("needed_ml", thousandths(record.resin->needed_ml));
  json.member("tank_ml", thousandths(record.resin->tank_ml));
  json.end_object();
}

void write_machine(JsonWriter& json, const PrinterRecord& record) {
  if (record.machine == nullptr) return json.null();
  const MachineRecord& machine = *record.machine;
  const auto left = machine.resin_ml();
  json.begin_object(kOneLine);
  json.member("resin_ml", mapped(left, thousandths));
  json.member("filled_ml", only_if(left.has_value(), thousandths(machine.filled_ml())));
  json.member("tank_ml", thousandths(machine.tank_ml()));
  json.member("lamp_h", thousandths(std::chrono::duration<double, std::ratio<3600>>(machine.lamp_lit()).count()));
  json.member("film_layers", machine.film_layers());
  json.key("hottest_c");
  json.begin_object(kOneLine);
  for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
    const auto site = static_cast<TemperatureSite>(i);
    json.member(to_string(site), mapped(machine.hottest(site), [](Celsius c) { return thousandths(c.value()); }));
  }
  json.end_object();
  json.key("unseen_faults");
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < machine.fault_count(); ++i) {
    FixedText<16> code;
    code.add("PL-%u", static_cast<unsigned>(machine.fault(i).code));
    json.value(code.view());
  }
  json.end_array();
  json.end_object();
}

void write_checks(JsonWriter& json, const PrinterRecord& record) {
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < kCheckCount; ++i) {
    if (record.checks[i].outcome == CheckOutcome::kNotReached) continue;
    json.begin_object(kOneLine);
    json.member("check", to_string(static_cast<Check>(i)));
    json.member("outcome", to_string(record.checks[i].outcome));
    json.member("detail", record.checks[i].detail.view());
    write_told(json, "told", record.checks[i].told);
    json.end_object();
  }
  json.end_array();
}

void write_findings(JsonWriter& json, const PrinterRecord& record) {
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < record.finding_count; ++i) {
    const FindingRecord& finding = record.findings[i];
    json.begin_object(kOneLine);
    json.member("severity", finding.severity == Severity::kNote ? "note" : "warning");
    json.member("text", finding.text.view());
    write_told(json, "told", finding.told);
    json.end_object();
  }
  json.end_array();
}

void write_fault(JsonWriter& json, const PrinterRecord& record) {
  if (!record.fault) return json.null();
  const FaultRecord& fault = *record.fault;
  const FaultWords& known = info(fault.code);
  FixedText<16> code;
  code.add("PL-%u", static_cast<unsigned>(fault.code));
  json.begin_object(kOneLine);
  json.member("code", code.view());
  json.member("title", known.title);
  json.member("meaning", known.meaning);
  text_or_null(json, "message", fault.message.view());
  write_told(json, "told", fault.told);
  json.member("remedy", fault.remedy.view());
  json.end_object();
}

}  // namespace

void write_told(JsonWriter& json, std::string_view name, const Told& told) {
  json.key(name);
  if (told.empty()) return json.null();
  json.begin_object(kOneLine);
  json.member("code", to_string(told.code));
  json.key("values");
  json.begin_object(kOneLine);
  for (std::size_t i = 0; i < told.count; ++i) {
    json.member(format_of(told.facts[i]).name, thousandths(told.values[i]));
  }
  json.end_object();
  if (!told.name().empty()) json.member("name", told.name());
  json.end_object();
}

Status write_state_line(TextSink& out, const PrinterRecord& record, std::uint64_t sequence) {
  JsonWriter json(out);
  json.begin_object(kOneLine);
  json.member("type", "state");
  json.member("protocol", kStateProtocol);
  json.member("sequence", sequence);
  json.member("plumbline", kVersion);
  json.member("printer", record.printer.view());
  json.member("simulated", record.simulated);
  json.member("state", to_string(record.state));
  text_or_null(json, "message", record.message.view());
  write_told(json, "message_told", record.message_told);
  text_or_null(json, "question", record.question.view());
  write_told(json, "question_told", record.question_told);
  id_or_null(json, "asks", record.question_id());
  json.key("commands");
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < kCommandCount; ++i) {
    if (const auto command = static_cast<Command>(i); takes(record, command)) json.value(to_string(command));
  }
  json.end_array();
  json.key("stick");
  write_stick(json, record);
  json.member("upload_limit", takes_upload(record) ? record.most_upload_bytes : std::uint64_t{0});
  json.key("upload");
  write_upload(json, record);
  json.key("stored");
  write_stored(json, record);
  json.key("job");
  write_job(json, record);
  json.key("proposals");
  write_proposals(json, record);
  json.key("profiles");
  write_profiles(json, record);
  json.key("slicing");
  write_slicing(json, record);
  json.key("sliced");
  write_sliced(json, record);
  json.key("pictures");
  write_pictures(json, record);
  json.member("masks", record.has_masks);
  json.member("report", record.has_report && at_rest(record.state));
  json.key("prints");
  write_prints(json, record);
  json.key("progress");
  write_progress(json, record);
  json.key("resin");
  write_resin(json, record);
  json.key("machine");
  write_machine(json, record);
  json.key("checks");
  write_checks(json, record);
  json.key("findings");
  write_findings(json, record);
  json.key("fault");
  write_fault(json, record);
  json.end_object();
  return json.finish();
}

Status write_reply_line(TextSink& out, std::optional<std::uint64_t> id, const Error* error,
                        std::optional<std::uint32_t> upload) {
  JsonWriter json(out);
  json.begin_object(kOneLine);
  json.member("type", "reply");
  json.member("id", id);
  json.member("ok", error == nullptr);
  if (upload) json.member("upload", *upload);
  if (error != nullptr) {
    json.member("error", error->finding());
    text_or_null(json, "advice", error->advice());
    write_told(json, "told", error->told());
  }
  json.end_object();
  return json.finish();
}

Status write_data_line(TextSink& out, std::optional<std::uint64_t> id, std::string_view members, std::string_view name,
                       std::string_view base64) {
  FixedText<200> head;
  head.add("{\"type\": \"reply\", \"id\": ");
  if (id) {
    head.add("%llu", static_cast<unsigned long long>(*id));
  } else {
    head.add("null");
  }
  head.add(", \"ok\": true, %.*s, \"%.*s\": \"", static_cast<int>(members.size()), members.data(),
           static_cast<int>(name.size()), name.data());
  PLUMBLINE_TRY(out.write(head.view()));
  PLUMBLINE_TRY(out.write(base64));
  return out.write("\"}\n");
}

}  // namespace plumbline
