#include "firmware/daemon/printer_daemon.hpp"

#include <unistd.h>

#include <array>
#include <cstddef>
#include <utility>

#include "firmware/daemon/job_change.hpp"
#include "firmware/daemon/offered_archive.hpp"
#include "firmware/daemon/remedies.hpp"
#include "firmware/daemon/scan_glances.hpp"
#include "firmware/daemon/stick/stick_reports.hpp"
#include "firmware/daemon/stick_request.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/print/job/machine_record.hpp"
#include "firmware/print/job/print_plan.hpp"
#include "firmware/print/status/print_state.hpp"
#include "firmware/slice/issue_report.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline::firmware {
namespace {

/// Touches more stack than any job uses, so that no job adds pages to it, and to the locked memory, after "ready".
[[gnu::noinline]] void grow_stack() {
  constexpr std::size_t kBytes = std::size_t{512} * 1024;
  constexpr std::size_t kPage = 4096;
  std::array<volatile char, kBytes> pages;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (std::size_t i = 0; i < kBytes; i += kPage) pages[i] = 0;
}

}  // namespace

PrinterDaemon::PrinterDaemon(Machine& machine, const DaemonSettings& settings, SlicingChild& child, Arena& arena,
                             JobStore& store, MachineRecord& machine_record, DaemonObserver& observer,
                             PrinterRecord& record, Uploads& uploads)
    : machine_(machine),
      settings_(settings),
      child_(child),
      arena_(arena),
      store_(store),
      machine_record_(machine_record),
      record_(record),
      observer_(record, machine.stick, observer, settings.id_seed),
      slicing_(child, machine, arena, observer_, settings.slicing_patience),
      decoder_(child, printer_volume(settings.board)),
      surroundings_(machine, settings.machine, machine_record, record),
      answers_(machine, record, observer_, surroundings_),
      uploads_(uploads),
      commands_(record, observer_, answers_, machine_record, uploads, settings.report_path) {
  record.state = PrintState::kIdle;
  record.machine = &machine_record;
  assign(record.printer, settings.board.name);
  record.simulated = settings.machine.simulated;
  record.has_report = has_report();
  record.mask_pixels = {settings.board.columns, settings.board.rows};
  record.mask_pixel_mm = {settings.board.pixel_pitch_x_mm, settings.board.pixel_pitch_y_mm};
  for (const std::string& name : settings.profiles) {
    if (record.profile_count < record.profiles.size()) assign(record.profiles[record.profile_count++], name);
  }
}

bool PrinterDaemon::has_report() const { return ::access(settings_.report_path.c_str(), R_OK) == 0; }

void PrinterDaemon::apply(PrintEvent event) {
  const PrintState before = record_.state;
  record_.state = next(before, event);
  if (event == PrintEvent::kAcknowledged) record_.fault.reset();
  if (record_.state == before) return;
  record_.asks = 0;  // no answer to what was asked before counts in another state
  show_on_panel(machine_.panel, record_.state);
}

bool PrinterDaemon::ending() const {
  return answers_.shutdown() || slicing_.shutdown() || record_.state == PrintState::kSuspended;
}

Status PrinterDaemon::run() {
  grow_stack();
  show_on_panel(machine_.panel, record_.state);
  if (settings_.machine.start == StartChoice::kOnStick) {
    observer_.say(
        "start = \"on_stick\" in the board file: a stick starts its print, nobody presses start. This is for test "
        "rigs");
  }
  while (!ending()) {
    const auto served = serve();
    if (served) continue;
    if (served.error().code() == ErrorCode::kPowerLost || child_.gone()) return served;
    refuse(served.error(), fault_of(served.error().code()));
  }
  observer_.say("shut down");
  return {};
}

Status PrinterDaemon::serve() {
  PLUMBLINE_TRY(settle());
  if (record_.state == PrintState::kInterrupted) return serve_interrupted();
  if (record_.state == PrintState::kPlateInUse) return serve_plate();
  if (record_.state == PrintState::kFault) return serve_fault();
  return serve_idle();
}

/// Leaves the idle state if there is a fault that nobody has seen, if a print is stored, or if its part is on the plate. No job is
/// offered before that.
Status PrinterDaemon::settle() {
  if (record_.state != PrintState::kIdle) return {};
  if (machine_record_.fault_count() > 0) {
    show_unseen_fault();
    return {};
  }
  const auto interrupted = has_interrupted_print(store_, machine_record_);
  PLUMBLINE_TRY(interrupted);
  if (*interrupted) {
    apply(PrintEvent::kResumeOffered);
  } else if (!machine_record_.plate_is_empty()) {
    apply(PrintEvent::kPlateTaken);
  }
  return {};
}

/// Waits for scans and offers them.
Status PrinterDaemon::serve_idle() {
  for (bool told_ready = false; !ending();) {
    if (again_ && port().has_stick()) return serve_scans(commands_.of_upload);
    again_.reset();  // its scan has left meanwhile
    if (uploads_.is_new()) return serve_scans(true);
    if (machine_.stick.has_stick() && stick_ == PortState::kNew) return serve_scans(false);
    if (uploads_.port().has_stick() && upload_ == PortState::kNew) return serve_scans(true);
    if (!std::exchange(told_ready, true)) observer_.say("ready");
    const auto event = answers_.look();
    PLUMBLINE_TRY(event);
    if (!*event) continue;
    const EventKind kind = (*event)->kind;
    const bool asks = kind == EventKind::kStartPressed;
    if (asks) upload_ = PortState::kNew;
    if (asks || kind == EventKind::kStickArrived || kind == EventKind::kStickDeparted) scans_came();
  }
  return {};
}

/// A print was interrupted and its part hangs in the printer, so nothing moves until the user decides.
Status PrinterDaemon::serve_interrupted() {
  answers_.put();
  observer_.say("an interrupted print can go on: press start to resume it, or cancel to give it up");
  while (!ending()) {
    const auto answer = answers_.ask();
    PLUMBLINE_TRY(answer);
    if (*answer == EventKind::kStartPressed) return resume();
    if (*answer != EventKind::kCancelPressed) continue;
    PLUMBLINE_TRY(machine_record_.keep());  // what the journal has, if it could not be kept before
    PLUMBLINE_TRY(store_.end());
    apply(PrintEvent::kCancelAsked);
    break;
  }
  return {};
}

Status PrinterDaemon::serve_plate() {
  answers_.put();
  observer_.say("is the plate empty? Take off what is on it, then press start");
  while (!ending()) {
    const auto answer = answers_.ask();
    PLUMBLINE_TRY(answer);
    if (*answer == EventKind::kStickArrived) scans_came();
    if (*answer != EventKind::kStartPressed) continue;
    PLUMBLINE_TRY(machine_record_.confirm_empty());
    observer_.plate_emptied();
    // Offers what was printed again. A rig's stick would start again, so there it has to be plugged in anew, after the print.
    if (commands_.of_upload || settings_.machine.start != StartChoice::kOnStick) last_port() = PortState::kNew;
    apply(PrintEvent::kPlateEmpty);
    break;
  }
  return {};
}

/// One of an earlier run of the program.
void PrinterDaemon::show_unseen_fault() {
  const auto [code, finding] = machine_record_.fault(0);
  const FaultText fault = explain(code, finding);
  apply(PrintEvent::kFailed);
  record_.set_fault(code, finding, fault.advice.view());
  observer_.say(fault.what.view());
}

/// Shows a fault until somebody has seen it. Whoever plugs in a stick or uploads a scan has seen that the job before was refused; the
/// fault of a print takes a button. A stick that goes proves nothing: a bad contact is enough.
Status PrinterDaemon::serve_fault() {
  answers_.put();
  while (!ending()) {
    const auto answer = answers_.ask();
    PLUMBLINE_TRY(answer);
    const bool button = *answer == EventKind::kStartPressed || *answer == EventKind::kCancelPressed;
    if (!button && (*answer != EventKind::kStickArrived || !machine_record_.plate_is_empty())) continue;
    PLUMBLINE_TRY(machine_record_.fault_seen());
    if (button || !uploads_.is_new()) {
      last_port() = *answer == EventKind::kCancelPressed ? PortState::kServed : PortState::kNew;
    }
    apply(PrintEvent::kAcknowledged);
    break;
  }
  return {};
}

/// @returns the job that somebody wants printed; none: nobody does, or the stick was pulled
Expected<std::optional<StickJob>> PrinterDaemon::choose(const StickMount& mount, bool uploaded) {
  const auto again = std::exchange(again_, std::nullopt);
  auto offer = StickOffer::read(mount, slicing_, settings_, observer_, uploaded);
  PLUMBLINE_TRY(offer);
  if (again && again->at_once && offer->job() == again->job) return offer->job();
  if (!again && !uploaded && offer->is_certain() && settings_.machine.start == StartChoice::kOnStick) {
    return offer->job();
  }
  EventKind answer{};
  do {
    ScanGlances glances(mount, *offer, record_, child_, slicing_, observer_, settings_);
    commands_.offer = &*offer;
    answers_.background = [&glances] { return glances.step(); };
    const auto asked = offer->ask(answers_, [this] { return uploads_.is_new(); });
    answers_.background = nullptr;
    commands_.offer = nullptr;
    glances.stop();
    PLUMBLINE_TRY(asked);
    answer = *asked;
    const auto opened = offer->open_folder(mount, slicing_);
    PLUMBLINE_TRY(opened);
    if (*opened) continue;
    if (!offer->take_wish()) break;
    PLUMBLINE_TRY(propose(mount, *offer));
  } while (!ending());
  if (answer == EventKind::kStartPressed && !ending()) return offer->job();
  // What has arrived meanwhile is offered next: a new upload, or a stick instead of an upload.
  if (uploaded && answer == EventKind::kStickArrived) scans_came();
  if (!uploaded && answer == EventKind::kStickDeparted) stick_ = PortState::kNew;
  return std::nullopt;
}

/// The job is offered again afterwards, also if somebody has stopped it.
Status PrinterDaemon::propose(const StickMount& mount, StickOffer& offer) {
  const StickJob& job = offer.job();
  const auto profile = profile_for(job);
  PLUMBLINE_TRY(profile);
  auto scan = open_scan(job, mount);
  PLUMBLINE_TRY(scan);
  auto request = stick_request(job, *scan, *profile, settings_);
  PLUMBLINE_TRY(request);
  request->proposes = true;
  observer_.proposing();
  apply(PrintEvent::kJobTaken);
  FixedText<400> text;
  text.add("finding the best orientations of %s", job.title().c_str());
  observer_.say(text.view());
  const auto proposals = slicing_.propose(mount, *scan, *request);
  if (proposals) {
    offer.propose(*proposals, child_.proposals());
  } else if (proposals.error().code() != ErrorCode::kCancelled || ending()) {
    return tl::unexpected<Error>(proposals.error());
  }
  record_.slicing.reset();
  apply(PrintEvent::kJobOffered);
  return {};
}

Expected<std::optional<Contract>> PrinterDaemon::agree(ReadJob& job, const PrintGrid& grid,
                                                       const StackFindings& findings, const MakeContract& make,
                                                       const MakeMasks& masks) {
  PrintProfile& profile = job.profile;
  auto contract = make(profile);
  PLUMBLINE_TRY(contract);
  // Without room for the masks there are none to look at.
  const auto to_look_at = masks(*contract);
  OfferedContract offered(job.request.name.view(), *contract, profile, job.untouched, make, observer_);
  offered.tell();
  // An archive stands as it was sliced.
  const auto mends = [&job](const Told& told) {
    const bool is_scan = std::holds_alternative<SlicedScan>(job.scan);
    return is_scan ? remedies_of(told, job.job, job.request.settings.supports.has_value()) : Remedies();
  };
  for_each_issue(findings, grid, profile.checks, [&](IssueKind kind, CheckAction, std::string_view sentence) {
    const Told told = told_issue(kind, findings, grid);
    observer_.warn(sentence, told, mends(told), places_of(kind, findings, grid));
  });
  const CheckAction action = verdict(findings, profile.checks);
  if (action == CheckAction::kRefuse) {
    refuse(judge(findings, grid, profile.checks, false).error(), FaultCode::kIssueFound);
    return std::nullopt;
  }
  const bool asks =
      action == CheckAction::kAsk || settings_.machine.start == StartChoice::kAfterPreview || contract->doubts != 0;
  if (asks) {
    apply(PrintEvent::kJobOffered);
    commands_.contract = &offered;
    commands_.masks = to_look_at ? to_look_at->get() : nullptr;
    record_.has_masks = to_look_at.has_value();
    Sentence found;
    if (action == CheckAction::kAsk) found = issue_counts(findings, profile.checks, CheckAction::kAsk);
    const auto accepted = offered.ask(found.view(), answers_);
    commands_.contract = nullptr;
    commands_.masks = nullptr;
    record_.has_masks = false;
    PLUMBLINE_TRY(accepted);
    apply(*accepted ? PrintEvent::kJobTaken : PrintEvent::kCancelAsked);
    if (!*accepted) return std::nullopt;
  }
  return *contract;
}

Expected<std::optional<Printable>> PrinterDaemon::prepare(ReadJob& job, const SlicedScan& sliced) {
  const std::string_view name = job.request.name.view();
  const auto contract = agree(
      job, sliced.rrep.grid, sliced.findings,
      [&](const PrintProfile& profile) {
        return contract_of(sliced, job.request.settings, profile, settings_.machine);
      },
      [&](const Contract& made) { return OfferedScanMasks::create(sliced, made.plan.grey, arena_); });
  PLUMBLINE_TRY(contract);
  if (!*contract) return std::nullopt;
  return printable_of(sliced, name, job.profile.name, **contract);
}

Expected<std::optional<Printable>> PrinterDaemon::prepare(ReadJob& job, JobStore::Received& archive) {
  const std::string_view name = job.request.name.view();
  const auto sliced = slicing_.check(archive.file.get(), job.request);
  PLUMBLINE_TRY(sliced);
  observer_.previewed(child_.pictures());
  for_each_remark(*sliced, [this](const Told& told, std::string_view remark) { observer_.warn(remark, told); });
  const auto profile = profile_of(job.profile, sliced->settings, name, job.job.print_values());
  PLUMBLINE_TRY(profile);
  job.profile = *profile;
  const auto untouched = profile_of(job.untouched, sliced->settings, name, observer_.kept().plain().print_values());
  PLUMBLINE_TRY(untouched);
  job.untouched = *untouched;
  const auto contract = agree(
      job, sliced->grid, sliced->findings,
      [&](const PrintProfile& changed) { return contract_of(*sliced, changed, settings_.machine); },
      [&](const Contract&) {
        return OfferedArchiveMasks::create(archive.file.get(), name, *sliced, decoder_,
                                           settings_.machine.panel.grey.has_grey(), arena_);
      });
  PLUMBLINE_TRY(contract);
  if (!*contract) return std::nullopt;
  return printable_of(*sliced, name, job.profile.name, **contract, std::move(archive.file), archive.hash);
}

bool PrinterDaemon::store_reports() {
  if (record_.prints == nullptr || !machine_.stick.has_stick()) return false;
  const auto stored = firmware::store_reports(machine_.stick, *record_.prints, settings_.board.name);
  if (!stored) {
    observer_.tell(stored.error().message(), PrinterCode::kReportsNotOnStick);
    return false;
  }
  if (stored->files > 0) {
    FixedText<120> text;
    text.add("%zu file%s of the last prints %s on the stick now, in plumbline-reports", stored->files,
             plural_s(stored->files), stored->files == 1 ? "is" : "are");
    observer_.tell(text.view(), {PrinterCode::kReportsOnStick, {{Fact::kCount, stored->files}}});
  }
  return stored->asked;
}

/// A stick has come or gone, or an upload has come. Only the first is a reason to offer a stick again.
void PrinterDaemon::scans_came() {
  if (!uploads_.is_new()) stick_ = PortState::kNew;
}

/// Offers what is in a port, and prints it if somebody wants that.
Status PrinterDaemon::serve_scans(bool uploaded) {
  if (uploaded && uploads_.take_new()) observer_.forget_upload();
  commands_.of_upload = uploaded;
  last_port() = PortState::kServed;
  fault_ = FaultCode::kNone;
  const bool wants_reports = !uploaded && store_reports();
  observer_.begin_job();
  apply(PrintEvent::kJobOffered);
  // Frees the arena at its end, so it is there before anything is read.
  PrintSession session(settings_.board, settings_.machine, arena_, &store_, &decoder_);
  std::optional<ReadJob> read;
  {
    const auto mount = port().mount();
    PLUMBLINE_TRY(mount);
    const auto wanted = choose(*mount, uploaded);
    // A stick may have come for the reports alone.
    const bool is_empty = !wanted && wanted.error().code() == ErrorCode::kNoPoints && wants_reports;
    if (!is_empty) PLUMBLINE_TRY(wanted);
    if (is_empty || !*wanted) {
      apply(PrintEvent::kCancelAsked);
      return {};
    }
    auto job = read_job(*mount, **wanted);
    PLUMBLINE_TRY(job);
    read = std::move(*job);
  }
  if (!uploaded) observer_.tell("the stick may be pulled", PrinterCode::kStickMayGo);
  return print_job(session, *std::move(read));
}

/// Takes all that the print needs from a mounted stick, so that it may be pulled afterwards.
Expected<PrinterDaemon::ReadJob> PrinterDaemon::read_job(const StickMount& mount, const StickJob& job) {
  const auto profile = profile_for(job);
  PLUMBLINE_TRY(profile);
  StickJob plain = job;
  plain.values = observer_.kept().plain().values;
  const auto untouched = profile_for(plain);
  PLUMBLINE_TRY(untouched);
  auto scan = open_scan(job, mount);
  PLUMBLINE_TRY(scan);
  apply(PrintEvent::kJobTaken);
  FixedText<400> text;
  text.add("reading %s, profile %s", job.title().c_str(), profile->name.c_str());
  observer_.say(text.view());
  const auto request = stick_request(job, *scan, *profile, settings_);
  PLUMBLINE_TRY(request);
  ReadJob read{*request, *profile, *untouched, job, {}};
  if (is_archive_name(job.scans[0])) {
    auto copied = slicing_.copy(mount, scan->front(), store_);
    PLUMBLINE_TRY(copied);
    read.scan = std::move(*copied);
    return read;
  }
  const auto sliced = slicing_.run(mount, *scan, *request);
  PLUMBLINE_TRY(sliced);
  read.scan = sliced->sliced;
  observer_.previewed(child_.pictures());
  for (std::size_t i = 0; i < sliced->remarks; ++i) {
    const Told& told = sliced->remark_told[i];
    observer_.warn(at_printer(told, sliced->remark[i].view()).view(), told,
                   remedies_of(told, job, request->settings.supports.has_value()));
  }
  return read;
}

/// Prints what was read, unless its checks or somebody who is asked about them forbid it.
Status PrinterDaemon::print_job(PrintSession& session, ReadJob job) {
  const auto take = [&]() -> Expected<bool> {
    auto wanted = std::visit([&](auto& scan) { return prepare(job, scan); }, job.scan);
    PLUMBLINE_TRY(wanted);
    if (!*wanted) return false;
    JobFacts& facts = (*wanted)->facts;
    facts.print_id = record_.job_id;
    for (const RequestedFile& file : job.request.files()) facts.add_file(file.name.view());
    PLUMBLINE_TRY(session.take(**std::move(wanted)));
    return true;
  };
  commands_.again = [&](const ClientRequest& request) { return again(job, request); };
  const auto taken = take();
  commands_.again = nullptr;
  if (taken && *taken) again_.reset();
  observer_.kept().keep(again_ ? again_->job : as_asked(job.job, job.profile));
  if (!taken || !*taken) store_.drop_received();
  PLUMBLINE_TRY(taken);
  if (!*taken) return {};
  apply(PrintEvent::kSliced);
  print(session, job.profile);
  return {};
}

Expected<PrintProfile> PrinterDaemon::profile_for(const StickJob& job) const {
  auto profile = settings_.profile(job.profile);
  PLUMBLINE_TRY(profile);
  set_values(*profile, job.print_values(), ValueSource::kPerson);
  profile->adaptive = job.is_adaptive();
  return profile;
}

Expected<bool> PrinterDaemon::again(const ReadJob& job, const ClientRequest& request) {
  const StickJob asked = as_asked(job.job, job.profile);
  const std::string_view key = request.key.view();
  if (request.command == Command::kSettings) {
    again_ = Again{asked, false};
    return true;
  }
  if (!scan_is_there(record_)) {
    return telling(Told(PrinterCode::kScanNotThere, {}, key),
                   fail(ErrorCode::kBadSetting,
                        "'%.*s': can't be changed, because the scan is no longer there.\tPut its stick in again, or "
                        "decline the print",
                        static_cast<int>(key.size()), key.data()));
  }
  StickJob changed = asked;
  const PrintField* const field = find_print_field(key);
  const bool is_value = field != nullptr && field->can_be_changed();  // then the profile has it
  if (!is_value) {
    PLUMBLINE_TRY(change_job(changed, key, request.value.view(), observer_.kept().plain(), settings_));
    if (changed == asked) return false;
    const auto profile = profile_for(changed);
    PLUMBLINE_TRY(profile);
    const bool cleared = clear_stale_supports(changed, asked, settings_);
    PLUMBLINE_TRY(changed.supports.over(profile->supports_enable, profile->supports));
    PLUMBLINE_TRY(plan_print(*profile, settings_.machine, finest_layer_mm(*profile), 1));
    if (cleared) observer_.supports_cleared();
  }
  again_ = Again{std::move(changed), true};
  return true;
}

Status PrinterDaemon::resume() {
  commands_.of_upload = false;
  PrintSession session(settings_.board, settings_.machine, arena_, &store_, &decoder_);
  const auto loaded = session.load();
  if (!loaded) {
    // Nothing is wrong with the journal: the process that decodes layers is gone. The next daemon resumes.
    if (child_.gone()) return tl::unexpected<Error>(loaded.error());
    const bool another = loaded.error().code() == ErrorCode::kUnsupported;
    refuse(loaded.error(), another ? FaultCode::kJournalOfAnother : FaultCode::kJournalDamaged);
    return {};
  }
  auto profile = settings_.profile(std::string(view(session.printable().facts.profile)));
  PLUMBLINE_TRY(profile);
  observer_.resumed(session);
  apply(PrintEvent::kJobResumed);
  print(session, *profile);
  return {};
}

void PrinterDaemon::print(PrintSession& session, const PrintProfile& profile) {
  record_.resin = ResinRecord{session.needed_ml(), settings_.machine.tank_volume_ml};
  observer_.begins(session.contract());
  const PrintReport& report = session.print(machine_, observer_, &machine_record_);
  observer_.printed(report, session, profile);
  record_.has_report = has_report();
  store_reports();
  // Don't print the same stick again until it is plugged in anew.
  if (!commands_.of_upload) stick_ = machine_.stick.has_stick() ? PortState::kServed : PortState::kNew;
  fault_ = report.fault;
  if (report.state == PrintState::kFault) keep_fault(report.fault, report.fault_message.view());
  // The print has left the record in its last state. A fault stays until somebody has seen it; after any other end, settle() asks for
  // the plate.
  if (report.state == PrintState::kFinished || report.state == PrintState::kCancelled) apply(PrintEvent::kAcknowledged);
}

/// If the storage fails, the fault is shown all the same, until the printer is switched off.
void PrinterDaemon::keep_fault(FaultCode code, std::string_view finding) {
  static_cast<void>(machine_record_.add_fault(code, finding));
}

/// Says why a job could not be printed, or that the user stopped it.
void PrinterDaemon::refuse(const Error& error, FaultCode code) {
  record_.slicing.reset();
  if (error.code() == ErrorCode::kCancelled) {
    apply(PrintEvent::kCancelAsked);
    apply(PrintEvent::kAcknowledged);
    observer_.say(ending() ? "reading stopped" : "cancelled");
    return;
  }
  fault_ = code;
  keep_fault(code, error.finding());
  apply(PrintEvent::kFailed);
  observer_.refused(code, error);
}

}  // namespace plumbline::firmware
