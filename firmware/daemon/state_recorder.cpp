#include "firmware/daemon/state_recorder.hpp"

#include <algorithm>
#include <array>

#include "firmware/io/wall_clock.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/print/status/print_lines.hpp"

namespace plumbline::firmware {

namespace {

/// Copies a picture that a child has drawn.
/// @returns false if there is none: its size may be anything
template <class Picture>
bool take(const Picture& drawn, Picture& to) {
  const std::uint32_t columns = drawn.columns, rows = drawn.rows;
  if (columns == 0 || rows == 0 || columns > Picture::kMostColumns || rows > Picture::kMostRows) return false;
  to = drawn;
  to.columns = columns;
  to.rows = rows;
  return true;
}

/// What an error of a scan says whose message has no code of its own.
Told told_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kCannotOpen: return PrinterCode::kFileNotOpened;
    case ErrorCode::kCannotRead: return PrinterCode::kFileNotRead;
    case ErrorCode::kUnknownFormat: return PrinterCode::kFormatUnknown;
    case ErrorCode::kMalformed: return PrinterCode::kFileDamaged;
    case ErrorCode::kTruncated: return PrinterCode::kFileCut;
    case ErrorCode::kNoPoints: return PrinterCode::kNothingToPrint;
    case ErrorCode::kUnsupported: return PrinterCode::kVariantUnknown;
    case ErrorCode::kOutOfMemory: return PrinterCode::kMemoryShort;
    case ErrorCode::kDoesNotFit: return PrinterCode::kTooLarge;
    case ErrorCode::kBadSetting: return PrinterCode::kSettingWrong;
    case ErrorCode::kNoSurface: return PrinterCode::kNoSurface;
    // Of the others the fault says what they mean.
    default: return {};
  }
}

}  // namespace

StateRecorder::StateRecorder(PrinterRecord& record, const StickPort& stick, DaemonObserver& observer,
                             std::uint64_t id_seed)
    : record_(record),
      stick_(stick),
      observer_(observer),
      ids_(id_seed),
      pictures_(std::make_unique<JobPictures>()),
      scan_pictures_(std::make_unique<ScanPictures>()),
      // A page may have kept pictures of a list that was there before this daemon began: their numbers must not come again.
      scan_picture_number_(static_cast<std::uint32_t>(ids_.next() >> 34U)) {
  record.pictures = pictures_.get();
  record.scan_pictures = scan_pictures_.get();
}

void StateRecorder::begin_job() {
  record_.begin_job();
  record_.job_id = ids_.next();
  pictures_->clear();
}

void StateRecorder::previewed(const SlicedPictures& drawn) {
  pictures_->preview_number += take(drawn.preview, pictures_->preview) ? 1 : 0;
  pictures_->issues_number += take(drawn.issues, pictures_->issues) ? 1 : 0;
  const std::uint32_t size = drawn.part.size;
  if (size == 0 || size > PartModel::kMostBytes) return;
  std::copy_n(drawn.part.memory.begin(), size, pictures_->part.memory.begin());
  pictures_->part.size = size;
  pictures_->part.box = drawn.part.box;
  ++pictures_->part_number;
}

void StateRecorder::glanced(std::size_t scan, const ScanPicture& drawn) {
  if (take(drawn, (*scan_pictures_)[scan])) record_.scans[scan].picture = ++scan_picture_number_;
}

void StateRecorder::proposing() {
  record_.slicing = SlicingRecord{.proposes = true};
  whole_ = WholeProgress(Stage::kNormals);
}

void StateRecorder::proposed(const Proposals& found, const ProposalPictures& drawn) {
  record_.slicing.reset();
  forget_proposals();
  record_.proposals = found;
  bool all = true;
  for (std::size_t i = 0; i < drawn.size(); ++i) all = take(drawn[i], pictures_->proposals[i]) && all;
  if (!all) return pictures_->clear_proposals();
  ++pictures_->proposal_number;
}

void StateRecorder::forget_proposals() {
  record_.proposals.reset();
  pictures_->clear_proposals();
}

void StateRecorder::mask_made(std::uint32_t layer, ConstBitImage mask) {
  draw_layer_picture(mask, pictures_->part.box, pictures_->next_layer());
  next_layer_ = layer;
  if (record_.progress) show_layer(record_.progress->layers_done);
  observer_.mask_made(layer, mask);
}

/// Shows the picture that waits if it is that of a layer.
void StateRecorder::show_layer(std::uint32_t layer) {
  if (next_layer_ != layer || !pictures_->next_layer().there()) return;
  pictures_->show_next_layer();
  pictures_->next_layer().clear();
}

void StateRecorder::say(const PrintableText& text) { tell(text, {}); }

void StateRecorder::tell(const PrintableText& text, const Told& told) {
  assign(record_.message, text.view());
  record_.message_told = told;
  observer_.say(text);
}

void StateRecorder::supports_cleared() {
  tell(
      "supports set by hand were cleared, because the object, its size, its orientation or its height above the plate "
      "has changed. Set them again once it is sliced",
      PrinterCode::kSupportsCleared);
}

void StateRecorder::look_around() {
  record_.has_stick = stick_.has_stick();
  if (!record_.has_stick) kept_.forget(false);
  if (!record_.has_stick && !record_.scans_uploaded) forget_scans();
  if (!record_.code.view().empty() && std::chrono::steady_clock::now() > code_until_) record_.code.clear();
}

void StateRecorder::show_code(std::string_view code) {
  assign(record_.code, code);
  code_until_ = std::chrono::steady_clock::now() + kCodeTime;
}

bool StateRecorder::update(const PrintStatus& status) {
  look_around();
  record_.slicing.reset();
  const PrintState before = record_.state;
  record_.set_progress(status, wall_clock_s());
  if (record_.state != before && waits_for_start(record_.state)) ask(status.now);
  show_layer(status.layer);
  assign(record_.message, status_text(status).view());
  record_.message_told = told_note(status);
  return observer_.update(status);
}

void StateRecorder::checked(Check check, const CheckResult& result) {
  record_.checks[static_cast<std::size_t>(check)] = result;
  observer_.checked(check, result);
}

void StateRecorder::slicing(Stage stage, double fraction) {
  look_around();
  if (!record_.slicing) whole_ = WholeProgress();
  const double whole = whole_.reach(stage, fraction);
  record_.slicing = SlicingRecord{stage, fraction, record_.slicing && record_.slicing->proposes, whole};
  observer_.slicing(stage, fraction);
}

void StateRecorder::printed(const PrintReport& report, const PrintSession& session, const PrintProfile& profile) {
  record_.result = report.state;
  if (report.fault != FaultCode::kNone) {
    record_.set_fault(report.fault, report.fault_message.view(), explain(report.fault, {}).advice.view(),
                      report.fault_told);
  }
  for_each_warning(
      report, [this](const Told& told, std::string_view text) { record_.add_finding(Severity::kWarning, text, told); });
  observer_.printed(report, session, profile);
}

void StateRecorder::idle() {
  look_around();
  observer_.idle();
}

void StateRecorder::forget_upload() {
  kept_.forget(true);
  if (record_.scans_uploaded) forget_scans();
}

void StateRecorder::forget_scans() {
  record_.scan_count = record_.folder_count = 0;
  record_.folder.clear();
  record_.left_out = {};
  folder_.clear();
}

void StateRecorder::found(const StickScans& scans, bool uploaded) {
  if (record_.scans_uploaded != uploaded || folder_ != scans.folder) forget_scans();
  record_.scans_uploaded = uploaded;
  const auto before = record_.scans;
  const std::size_t count_before = record_.scan_count;
  record_.has_job_file = !scans.job_file.view().empty();
  record_.scan_count = record_.folder_count = 0;
  folder_ = scans.folder;
  assign(record_.folder, folder_);
  for (const StickFolder& folder : scans.folders) {
    FolderRecord& known = record_.folders[record_.folder_count++];
    assign(known.name, scans.name_within(folder.name));
    known.entries = static_cast<std::uint32_t>(folder.entries);
  }
  tell_left_out(scans);
  for (const StickEntry& entry : scans.list) {
    ScanRecord& scan = record_.scans[record_.scan_count++];
    scan = {};
    assign(scan.name, scans.name_within(entry.names[0]));
    scan.files = static_cast<std::uint32_t>(entry.names.size());
    scan.bytes = entry.bytes;
    for (std::size_t k = 0; k < count_before; ++k) {
      const ScanRecord& known_one = before[k];
      if (known_one.name.view() != scan.name.view() || known_one.files != scan.files || known_one.bytes != scan.bytes)
        continue;
      scan.problem = known_one.problem;
      scan.told = known_one.told;
      if (k + 1 == record_.scan_count) scan.picture = known_one.picture;  // it is still there
      break;
    }
    if (entry.bytes == 0 && scan.files == 1 && scan.problem.view().empty()) {
      assign(scan.problem, "the file is empty");
      scan.told = ToldCode::kFileEmpty;
    }
    if (scan.files > kMostScans) {
      FixedText<80> text;
      text.add("one scan may have %zu files at most", kMostScans);
      assign(scan.problem, text.view());
      scan.told = {PrinterCode::kTooManyFiles, {{Fact::kCount, kMostScans}}};
    }
  }
}

/// Says what nobody can choose, and how much it is.
void StateRecorder::tell_left_out(const StickScans& scans) {
  LeftOutRecord& left_out = record_.left_out;
  left_out = {scans.left_out, scans.folders_left_out, scans.partitions_left_out, {}, PrinterCode::kStickNotListed};
  const auto add = [&](std::size_t count, const char* one, const char* more, auto fact) {
    if (count == 0) return;
    left_out.text.add("%s%zu %s", left_out.text.view().empty() ? "not listed: " : ", ", count, count == 1 ? one : more);
    left_out.told.add(static_cast<Fact>(fact), static_cast<double>(count));
  };
  add(left_out.files, "file", "files", Fact::kCount);
  add(left_out.folders, "folder", "folders", PrinterFact::kFolders);
  add(left_out.partitions, "partition that can't be read", "partitions that can't be read", PrinterFact::kPartitions);
  if (left_out.text.view().empty()) {
    left_out.told = {};
  } else {
    tell(left_out.text.view(), left_out.told);
  }
}

void StateRecorder::offered(const StickJob& job, std::string_view profile, std::optional<std::size_t> chosen) {
  // In another folder the first one is another scan.
  FixedText<256> scan;
  assign(scan, job.title());
  const bool is_other = record_.job && (record_.job->chosen != chosen || record_.job->scan.view() != scan.view());
  if (is_other) record_.job_id = ids_.next();
  ask_about_other();
  JobRecord& record = record_.job.emplace();
  static_cast<JobSettings&>(record) = job;
  record.scan = scan;
  for (const std::string& file : job.scans) {
    if (record.file_count < record.files.size()) assign(record.files[record.file_count++], file);
  }
  assign(record.profile, profile);
  record.chosen = chosen;
}

void StateRecorder::resumed(const PrintSession& session) {
  begin_job();
  record_.job_id = session.printable().facts.print_id;
  JobRecord& record = record_.job.emplace();
  assign(record.scan, view(session.printable().facts.scan));
  for (const FileName& file : session.printable().facts.scan_files())
    assign(record.files[record.file_count++], view(file));
  assign(record.profile, view(session.printable().facts.profile));
}

void StateRecorder::contracted(const Contract& contract) {
  record_.sliced = contract;
  record_.slicing.reset();
  for (const ToldCode doubt :
       {static_cast<ToldCode>(PrinterCode::kArchiveNoHeight), static_cast<ToldCode>(PrinterCode::kArchiveNoExposure),
        static_cast<ToldCode>(PrinterCode::kArchiveGrey), ToldCode::kPointsOff}) {
    record_.remove_findings(doubt);
  }
}

void StateRecorder::begins(const Contract& contract) {
  contracted(contract);
  observer_.begins(contract);
}

void StateRecorder::warn(std::string_view sentence, const Told& told, const Remedies& remedies,
                         const IssuePlaces& places) {
  tell(sentence, told);
  record_.add_finding(Severity::kWarning, sentence, told, remedies, places);
}

void StateRecorder::refused(FaultCode code, const Error& error) {
  const FaultText fault = explain(code, error.finding(), error.advice());
  const bool of_scan = code == fault_of(error.code());
  const Told told = error.told().empty() && of_scan ? told_of(error.code()) : error.told();
  const ToldText advice = printer_remedy(told, fault.advice.view());
  record_.set_fault(code, error.finding(), advice.view(), told);
  if (record_.job && record_.job->chosen && *record_.job->chosen < record_.scan_count) {
    assign(record_.scans[*record_.job->chosen].problem, fault.what.view());
    record_.scans[*record_.job->chosen].told = told;
  }
  FixedText<1000> text;
  text.add("%s. %s", fault.what.c_str(), advice.c_str());
  say(text.view());
}

}  // namespace plumbline::firmware
