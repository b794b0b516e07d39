#include "firmware/state/state_line.hpp"

#include "firmware/io/random_id.hpp"
#include "firmware/io/text/json_fields.hpp"
#include "firmware/io/version.hpp"
#include "firmware/io/wall_clock.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/state/command_rules.hpp"
#include "firmware/state/picture_line.hpp"

namespace plumbline::firmware::inline state {
namespace {

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

/// JsonField::write of a text; null if it is empty.
template <auto of, class T>
void text_or_null(JsonWriter& json, const T& from) {
  const std::string_view text = std::invoke(of, from).view();
  json.value(only_if(!text.empty(), text));
}

/// JsonField::write of an id; null if it is 0.
template <auto of, class T>
void id_or_null(JsonWriter& json, const T& from) {
  const std::uint64_t id = std::invoke(of, from);
  json.value(only_if(id != 0, id_text(id)));
}

/// JsonField::write of what is told.
template <auto of, class T>
void told(JsonWriter& json, const T& from) {
  write_told(json, std::invoke(of, from));
}

/// An array of objects, each with its number first.
/// @param number  of the first one
template <class T, std::size_t N>
void write_numbered(JsonWriter& json, const JsonField<T> (&fields)[N], std::span<const T> items, std::uint32_t number) {
  json.begin_array(kOneLine);
  for (const T& item : items) {
    json.begin_object(kOneLine);
    json.member("number", number++);
    write_fields(json, fields, item);
    json.end_object();
  }
  json.end_array();
}

constexpr JsonField<ScanRecord> kListedScanFields[] = {
    {"name", member<&ScanRecord::name>},
    {"files", member<&ScanRecord::files>},
    {"bytes", member<&ScanRecord::bytes>},
    {"problem", text_or_null<&ScanRecord::problem>},
    {"told", told<&ScanRecord::told>},
    {"picture", [](auto& json, auto& scan) { json.value(only_if(scan.picture > 0, scan.picture)); }},
};

constexpr JsonField<FolderRecord> kFolderFields[] = {{"name", member<&FolderRecord::name>},
                                                     {"entries", member<&FolderRecord::entries>}};

constexpr JsonField<LeftOutRecord> kLeftOutFields[] = {
    {"left_out", member<&LeftOutRecord::files>},
    {"folders_left_out", member<&LeftOutRecord::folders>},
    {"partitions_left_out", member<&LeftOutRecord::partitions>},
    {"not_listed", text_or_null<&LeftOutRecord::text>},
    {"not_listed_told", told<&LeftOutRecord::told>},
};

void write_stick(JsonWriter& json, const PrinterRecord& record) {
  json.begin_object(kOneLine);
  json.member("present", record.has_stick);
  json.member("job_file", record.has_job_file);
  json.key("folder");
  text_or_null<&PrinterRecord::folder>(json, record);
  json.key("scans");
  write_numbered(json, kListedScanFields, std::span(record.scans).first(record.scan_count), 1);
  json.key("folders");
  write_numbered(json, kFolderFields, std::span(record.folders).first(record.folder_count), 1);
  write_fields(json, kLeftOutFields, record.left_out);
  json.member("uploaded", record.scans_uploaded);
  json.end_object();
}

constexpr std::array<std::string_view, 3> kUploadWords = {"coming", "kept", "failed"};  ///< by UploadRecord::Stage

constexpr JsonField<UploadRecord> kUploadFields[] = {
    {"number", member<&UploadRecord::number>},
    {"stage", [](auto& json, auto& upload) { json.value(kUploadWords[static_cast<std::size_t>(upload.stage)]); }},
    {"name", member<&UploadRecord::name>},
    {"bytes", member<&UploadRecord::bytes>},
    {"received", member<&UploadRecord::received>},
    {"problem", text_or_null<&UploadRecord::problem>},
    {"told", told<&UploadRecord::told>},
};

constexpr JsonField<StoredRecord> kStoredFields[] = {{"name", member<&StoredRecord::name>},
                                                     {"bytes", member<&StoredRecord::bytes>}};

constexpr JsonField<PrintSize> kSizeFields[] = {{"side", member<&PrintSize::side>}, {"mm", member<&PrintSize::mm>}};

void write_supports(JsonWriter& json, const SupportChoice& choice) {
  json.member("supports", mapped(choice.enable, [](bool wanted) { return wanted ? "auto" : "none"; }));
  json.begin_object("support_values", kOneLine);
  if (choice.preset) json.member("support_preset", kPresetWords[*choice.preset]);
  if (choice.stand) json.member("support_stand", kStandWords[static_cast<std::size_t>(*choice.stand)]);
  if (choice.buildplate_only) json.member("support_buildplate_only", *choice.buildplate_only);
  for (std::size_t i = 0; i < kSupportFields.size(); ++i) {
    if (choice.values[i]) json.member(kSupportFields[i].key, *choice.values[i]);
  }
  for (std::size_t i = 0; i < kPlaceFields.size(); ++i) {
    if (choice.places[i].count > 0) write_places(json, kPlaceFields[i], choice.places[i]);
  }
  json.end_object();
}

void write_job(JsonWriter& json, const PrinterRecord& record) {
  if (!record.job) return json.null();
  const JobRecord& job = *record.job;
  json.begin_object(kOneLine);
  json.key("id");
  id_or_null<&PrinterRecord::job_id>(json, record);
  json.member("scan", job.scan);
  json.member("files", std::span(job.files).first(job.file_count));
  json.member("number", mapped(job.chosen, [](auto i) { return static_cast<std::uint32_t>(i + 1); }));
  json.member("profile", job.profile);
  json.member("units", job.units);
  json.member("scale", job.scale);
  json.member("fit", job.fit);
  json.key("size");
  write_object(json, kSizeFields, job.size);
  json.member("orient", job.orient ? "auto" : "none");
  json.member("keep_clean", kCleanSideWords[static_cast<std::size_t>(job.keep_clean)]);
  json.key("floor");
  if (job.floor.kind == FloorChoice::Kind::kHeight) {
    json.value(job.floor.height);
  } else {
    json.value(job.floor.kind == FloorChoice::Kind::kAuto ? "auto" : "keep");
  }
  json.member("rotate_x_deg", job.rotate_x_deg);
  json.member("rotate_y_deg", job.rotate_y_deg);
  json.member("rotate_z_deg", job.rotate_z_deg);
  if (job.is_adaptive()) {
    json.member("layer_height", kAdaptiveWord);
  } else {
    json.member("layer_height", only_if(job.layer_height > 0, job.layer_height));
  }
  write_supports(json, job.supports);
  json.member("proposal", mapped(record.proposal(), [](auto i) { return static_cast<std::uint32_t>(i); }));
  json.member("as", job.as);
  json.member("base", job.base);
  json.member("keep_all", job.keep_all);
  json.begin_object("values", kOneLine);
  for (const PrintField& field : kPrintFields) {
    if (const auto value = job.values[index_of(field.key)]) json.member(field.name, *value);
  }
  json.end_object();
  json.member("result", record.result);
  json.end_object();
}

constexpr JsonField<Proposal> kProposalFields[] = {
    {"rotate_x_deg", [](auto& json, auto& way) { json.value(way.degrees[0]); }},
    {"rotate_y_deg", [](auto& json, auto& way) { json.value(way.degrees[1]); }},
    {"support_mm2", rounded<&Proposal::support_mm2>},
    {"support_ml", [](auto& json, auto& way) { json.value(thousandths(way.support_mm3 / 1000)); }},
    {"peel_mm2", rounded<&Proposal::peel_mm2>},
    {"height_mm", rounded<&Proposal::height_mm>},
    {"scar_mm2", rounded<&Proposal::scar_mm2>},
    {"layers", member<&Proposal::layers>},
    {"tips", [](auto& json, auto& way) { json.value(only_if(way.counted != 0, way.tips)); }},
    {"tip_scars_mm2",
     [](auto& json, auto& way) { json.value(only_if(way.counted != 0, thousandths(way.tip_scars_mm2))); }},
    {"supports_ml",
     [](auto& json, auto& way) { json.value(only_if(way.counted != 0, thousandths(way.supports_mm3 / 1000))); }},
};

void write_proposals(JsonWriter& json, const PrinterRecord& record) {
  if (!record.proposals) return json.null();
  write_numbered(json, kProposalFields, std::span<const Proposal>(*record.proposals), 0);
}

void write_sliced(JsonWriter& json, const PrinterRecord& record) {
  if (!record.sliced) return json.null();
  json.begin_object(kOneLine);
  // The lengths of the object when it has shrunk, like those of places in it. `values` has those of the machine.
  const Vec3d shrinks = record.sliced->sizes.relative();
  constexpr double kDigits = 1e6;
  const double layer_mm = record.sliced->plan.layer_height.millimetres() / shrinks[2];
  json.member("layer_height_mm", std::round(layer_mm * kDigits) / kDigits);
  json.member("layers", record.sliced->plan.layers);
  json.begin_array("layer_runs", kOneLine);
  for (const LayerSteps::Run& run : record.sliced->plan.steps.runs()) {
    json.value(std::array<std::uint32_t, 2>{run.layers_end, run.step});
  }
  json.end_array();
  json.member("mask_pixels", record.mask_pixels);
  json.member("mask_pixel_mm", std::array{record.mask_pixel_mm[0] / shrinks[0], record.mask_pixel_mm[1] / shrinks[1]});
  write_contract(json, *record.sliced);
  json.end_object();
}

/// The number of a picture, which rises when there is another one; null: there is none.
void write_pictures(JsonWriter& json, const PrinterRecord& record) {
  json.begin_object(kOneLine);
  for (std::size_t i = 0; i < static_cast<std::size_t>(PictureName::kScan); ++i) {
    const auto drawn = drawn_picture(record, static_cast<PictureName>(i), 0);
    json.member(kPictureWords[i], mapped(drawn, [](const DrawnPicture& picture) { return picture.number; }));
  }
  json.end_object();
}

constexpr JsonField<SlicingRecord> kSlicingFields[] = {{"stage", member<&SlicingRecord::stage>},
                                                       {"fraction", rounded<&SlicingRecord::fraction>},
                                                       {"whole", rounded<&SlicingRecord::whole>},
                                                       {"proposes", member<&SlicingRecord::proposes>}};

constexpr JsonField<ProgressRecord> kProgressFields[] = {
    {"layers_done", member<&ProgressRecord::layers_done>},
    {"layers", member<&ProgressRecord::layers>},
    {"height_mm", rounded<&ProgressRecord::height_mm>},
    {"elapsed_s", member<&ProgressRecord::elapsed>},
    {"left_s", member<&ProgressRecord::left>},
    {"ends_at", [](auto& json, auto& progress) { json.value(utc_text(progress.ends_at)); }},
    {"slack_s", rounded<&ProgressRecord::slack>},
};

constexpr JsonField<KeptPrint> kKeptFields[] = {
    {"number", member<&KeptPrint::number>},
    {"scan", [](auto& json, auto& print) { json.value(view(print.scan)); }},
    {"profile", [](auto& json, auto& print) { json.value(view(print.profile)); }},
    {"result", [](auto& json, auto& print) { json.value(static_cast<PrintState>(print.result)); }},
    {"layers_done", member<&KeptPrint::layers_done>},
    {"layers", member<&KeptPrint::layers>},
    {"resin_ml", rounded<&KeptPrint::resin_ml>},
    {"ended_at", [](auto& json, auto& print) { json.value(utc_text(print.ended_at)); }},
    {"preview", [](auto& json, auto& print) { json.value(print.preview_bytes > 0); }},
};

void write_resin(JsonWriter& json, const PrinterRecord& record) {
  if (!record.resin) return json.null();
  json.begin_object(kOneLine);
  json.member("used_ml", thousandths(record.progress ? record.progress->resin_ml : 0));
  json.member("needed_ml", thousandths(record.resin->needed_ml));
  json.member("tank_ml", thousandths(record.resin->tank_ml));
  json.end_object();
}

void write_hottest(JsonWriter& json, const MachineRecord& machine) {
  json.begin_object(kOneLine);
  for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
    const auto site = static_cast<TemperatureSite>(i);
    json.member(to_string(site), mapped(machine.hottest(site), [](Celsius c) { return thousandths(c.value()); }));
  }
  json.end_object();
}

void write_temperatures(JsonWriter& json, const PrinterRecord& record) {
  json.begin_object(kOneLine);
  for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
    const auto site = static_cast<TemperatureSite>(i);
    const auto read = record.machine != nullptr ? record.machine->latest(site) : std::nullopt;
    // Without a fraction: what a sensor scatters by would make a new state every few seconds. + 0.0 turns -0 into 0.
    json.member(to_string(site), mapped(read, [](Celsius c) { return std::round(c.value()) + 0.0; }));
  }
  json.end_object();
}

void write_unseen_faults(JsonWriter& json, const MachineRecord& machine) {
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < machine.fault_count(); ++i) json.value(machine.fault(i).code);
  json.end_array();
}

double lamp_hours(const MachineRecord& machine) {
  return std::chrono::duration<double, std::ratio<3600>>(machine.lamp_lit()).count();
}

/// @returns none: nobody has said how much is in the tank
std::optional<double> filled_ml(const MachineRecord& machine) {
  return only_if(machine.resin_ml().has_value(), machine.filled_ml());
}

constexpr JsonField<MachineRecord> kMachineFields[] = {
    {"resin_ml", rounded<&MachineRecord::resin_ml>},
    {"filled_ml", rounded<filled_ml>},
    {"tank_ml", rounded<&MachineRecord::tank_ml>},
    {"lamp_h", rounded<lamp_hours>},
    {"film_layers", member<&MachineRecord::film_layers>},
    {"hottest_c", write_hottest},
    {"unseen_faults", write_unseen_faults},
};

constexpr JsonField<CheckResult> kCheckFields[] = {{"outcome", member<&CheckResult::outcome>},
                                                   {"detail", member<&CheckResult::detail>},
                                                   {"told", told<&CheckResult::told>}};

void write_checks(JsonWriter& json, const PrinterRecord& record) {
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < kCheckCount; ++i) {
    if (record.checks[i].outcome == CheckOutcome::kNotReached) continue;
    json.begin_object(kOneLine);
    json.member("check", static_cast<Check>(i));
    write_fields(json, kCheckFields, record.checks[i]);
    json.end_object();
  }
  json.end_array();
}

constexpr JsonField<Remedy> kRemedyFields[] = {{"key", member<&Remedy::key>}, {"value", member<&Remedy::value>}};

constexpr JsonField<FindingRecord> kFindingFields[] = {
    {"severity", [](auto& json, auto& f) { json.value(f.severity == Severity::kNote ? "note" : "warning"); }},
    {"text", member<&FindingRecord::text>},
    {"told", told<&FindingRecord::told>},
    {"remedies",
     [](auto& json, auto& f) {
       write_objects(json, kRemedyFields, std::span(f.remedies.list).first(f.remedies.count));
     }},
    {"places_mm", [](auto& json, auto& f) { json.value(std::span(f.places.mm).first(f.places.count)); }},
};

constexpr JsonField<FaultRecord> kFaultFields[] = {
    {"code", member<&FaultRecord::code>},
    {"title", [](auto& json, auto& fault) { json.value(info(fault.code).title); }},
    {"meaning", [](auto& json, auto& fault) { json.value(info(fault.code).meaning); }},
    {"message", text_or_null<&FaultRecord::message>},
    {"told", told<&FaultRecord::told>},
    {"remedy", member<&FaultRecord::remedy>},
};

void write_commands(JsonWriter& json, const PrinterRecord& record) {
  json.begin_array(kOneLine);
  for (std::size_t i = 0; i < kCommandCount; ++i) {
    if (const auto command = static_cast<Command>(i); takes(record, command)) json.value(command);
  }
  json.end_array();
}

constexpr JsonField<PrinterRecord> kStateFields[] = {
    {"printer", member<&PrinterRecord::printer>},
    {"simulated", member<&PrinterRecord::simulated>},
    {"address", text_or_null<&PrinterRecord::address>},
    {"state", member<&PrinterRecord::state>},
    {"message", text_or_null<&PrinterRecord::message>},
    {"message_told", told<&PrinterRecord::message_told>},
    {"question", text_or_null<&PrinterRecord::question>},
    {"question_told", told<&PrinterRecord::question_told>},
    {"asks", id_or_null<&PrinterRecord::question_id>},
    {"commands", write_commands},
    {"stick", write_stick},
    {"upload_limit", [](auto& json, auto& r) { json.value(takes_upload(r) ? r.most_upload_bytes : 0); }},
    {"upload", object<&PrinterRecord::upload, kUploadFields>},
    {"stored", object<&PrinterRecord::stored, kStoredFields>},
    {"job", write_job},
    {"proposals", write_proposals},
    {"profiles", [](auto& json, auto& r) { json.value(std::span(r.profiles).first(r.profile_count)); }},
    {"slicing", object<&PrinterRecord::slicing, kSlicingFields>},
    {"sliced", write_sliced},
    {"pictures", write_pictures},
    {"masks", member<&PrinterRecord::has_masks>},
    {"report", [](auto& json, auto& record) { json.value(record.has_report && at_rest(record.state)); }},
    {"prints",
     [](auto& json, auto& r) {
       write_objects(json, kKeptFields, r.prints != nullptr ? r.prints->list() : std::span<const KeptPrint>());
     }},
    {"progress", object<&PrinterRecord::progress, kProgressFields>},
    {"resin", write_resin},
    {"machine", object<&PrinterRecord::machine, kMachineFields>},
    {"temperatures_c", write_temperatures},
    {"checks", write_checks},
    {"findings",
     [](auto& json, auto& r) { write_objects(json, kFindingFields, std::span(r.findings).first(r.finding_count)); }},
    {"fault", object<&PrinterRecord::fault, kFaultFields>},
};

}  // namespace

void write_told(JsonWriter& json, const Told& told) {
  if (told.empty()) return json.null();
  json.begin_object(kOneLine);
  json.member("code", firmware::to_string(told.code));
  json.begin_object("values", kOneLine);
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
  write_fields(json, kStateFields, record);
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
    json.member("advice", only_if(!error->advice().empty(), error->advice()));
    json.key("told");
    write_told(json, error->told());
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

}  // namespace plumbline::firmware::inline state
