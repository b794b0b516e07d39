#include "firmware/daemon/printer_daemon.hpp"

#include <array>
#include <cstddef>
#include <utility>

#include "firmware/daemon/job_setting.hpp"
#include "firmware/daemon/stick_words.hpp"
#include "firmware/print/status/state_lights.hpp"
#include "firmware/settings/support_choice.hpp"
#include "firmware/slice/issue_report.hpp"
#include "slicer/support_building.hpp"

namespace plumbline {
namespace {

/// Touches as much stack as any job needs, so that it does not grow, and lock more memory, after "ready".
[[gnu::noinline]] void grow_stack() {
  constexpr std::size_t kBytes = std::size_t{256} * 1024;
  constexpr std::size_t kPage = 4096;
  std::array<volatile char, kBytes> pages;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (std::size_t i = 0; i < kBytes; i += kPage) pages[i] = 0;
}

/// How long the daemon waits for an event before its next turn. Shorter responds faster, longer spares the processor.
constexpr nanoseconds kLook = std::chrono::milliseconds(200);

/// A press this soon after a question answers the one before it: whoever presses start twice must not print onto a full plate.
constexpr nanoseconds kSettle = std::chrono::seconds(1);

}  // namespace

PrinterDaemon::PrinterDaemon(Machine& machine, const DaemonSettings& settings, SlicingChild& child, Arena& arena,
                             JobStore& store, PlateRecord& plate, DaemonObserver& observer, PrinterRecord& record)
    : machine_(machine),
      settings_(settings),
      child_(child),
      arena_(arena),
      store_(store),
      plate_(plate),
      record_(record),
      observer_(record, machine.stick, observer),
      slicing_(child, machine, arena, observer_, settings.slicing_patience) {
  assign(record.printer, settings.board.name);
  record.simulated = settings.machine.simulated;
}

void PrinterDaemon::apply(PrintEvent event) {
  const PrintState before = state_;
  state_ = next(state_, event);
  record_.state = state_;
  if (event == PrintEvent::kAcknowledged) record_.fault.reset();
  if (state_ == before) return;
  if (state_ == PrintState::kIdle) told_ready_ = false;
  show_on_panel(machine_.panel, state_);
}

Status PrinterDaemon::run() {
  grow_stack();
  show_on_panel(machine_.panel, state_);
  if (settings_.machine.start == StartChoice::kOnStick) {
    observer_.say(
        "start = \"on_stick\" in the board file: a stick starts its print, nobody presses start. This is for test "
        "rigs");
  }
  while (!ending_) {
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
  if (state_ == PrintState::kInterrupted) return serve_interrupted();
  if (state_ == PrintState::kPlateInUse) return serve_plate();
  if (state_ == PrintState::kFault) return serve_fault();
  return serve_idle();
}

/// Leaves the idle state if a print is stored, or if its part is on the plate. No job is offered before that.
Status PrinterDaemon::settle() {
  if (state_ != PrintState::kIdle) return {};
  const auto interrupted = has_interrupted();
  PLUMBLINE_TRY(interrupted);
  if (*interrupted) {
    apply(PrintEvent::kResumeOffered);
  } else if (!plate_.is_empty()) {
    apply(PrintEvent::kPlateTaken);
  }
  return {};
}

/// Whether a print is stored that has begun. One that has not is removed: the power went before its checks had passed, so nothing
/// of it is on the plate.
Expected<bool> PrinterDaemon::has_interrupted() {
  if (!store_.has_job()) return false;
  const auto progress = store_.progress();
  const bool none_cured = progress ? *progress == JournalEntry() : progress.error().code() == ErrorCode::kTruncated;
  if (plate_.is_empty() && none_cured) {
    PLUMBLINE_TRY(store_.end());
    return false;
  }
  PLUMBLINE_TRY(plate_.take());
  return true;
}

Status PrinterDaemon::serve_idle() {
  if (machine_.stick.has_stick() && !served_) return serve_stick();
  if (!std::exchange(told_ready_, true)) observer_.say("ready");
  record_.waits = true;
  const auto event = machine_.events.next_event(machine_.clock.now() + kLook);
  record_.waits = false;
  PLUMBLINE_TRY(event);
  observer_.idle();
  if (!*event) return {};
  switch ((*event)->kind) {
    case EventKind::kShutdownRequested: ending_ = true; return {};
    case EventKind::kStickArrived:
    case EventKind::kStickDeparted:
    case EventKind::kStartPressed: served_ = false; return {};
    case EventKind::kCancelPressed:
    case EventKind::kPausePressed:
    case EventKind::kCoverOpened:
    case EventKind::kCoverClosed:
    case EventKind::kExposureEnded:
    case EventKind::kMotionEnded: return {};
  }
  return {};
}

/// Waits for start, cancel, a stick that comes or goes, or a shutdown. Pause means "the next one".
Expected<EventKind> PrinterDaemon::ask(const std::function<void()>& on_next) {
  const TimePoint asked = machine_.clock.now();
  for (;;) {
    record_.waits = true;
    by_command_ = false;
    const auto event = machine_.events.next_event(machine_.clock.now() + kLook);
    record_.waits = false;
    const bool by_command = std::exchange(by_command_, false);
    PLUMBLINE_TRY(event);
    observer_.idle();
    if (!*event) continue;
    const EventKind kind = (*event)->kind;
    switch (kind) {
      case EventKind::kStartPressed:
      case EventKind::kCancelPressed:
        if (!by_command && (*event)->at < asked + kSettle) break;
        return kind;
      case EventKind::kShutdownRequested: ending_ = true; return kind;
      case EventKind::kStickArrived:
      case EventKind::kStickDeparted: return kind;
      case EventKind::kPausePressed: on_next(); break;
      case EventKind::kCoverOpened:
      case EventKind::kCoverClosed:
      case EventKind::kExposureEnded:
      case EventKind::kMotionEnded: break;
    }
  }
}

/// A print was interrupted and its part hangs in the printer, so nothing moves until the user decides.
Status PrinterDaemon::serve_interrupted() {
  observer_.say("an interrupted print can go on: press start to resume it, or cancel to give it up");
  while (!ending_) {
    const auto answer = ask([] {});
    PLUMBLINE_TRY(answer);
    if (*answer == EventKind::kStartPressed) return resume();
    if (*answer != EventKind::kCancelPressed) continue;
    PLUMBLINE_TRY(store_.end());
    apply(PrintEvent::kCancelAsked);
    break;
  }
  return {};
}

Status PrinterDaemon::serve_plate() {
  observer_.say("is the plate empty? Take off what is on it, then press start");
  while (!ending_) {
    const auto answer = ask([] {});
    PLUMBLINE_TRY(answer);
    if (*answer != EventKind::kStartPressed) continue;
    PLUMBLINE_TRY(plate_.confirm_empty());
    // Offers the stick in the port again. A rig's would start again, so there it has to be plugged in anew.
    served_ = served_ && settings_.machine.start == StartChoice::kOnStick;
    apply(PrintEvent::kPlateEmpty);
    break;
  }
  return {};
}

/// Shows a fault until somebody has seen it. Whoever changes the stick has seen that its job was refused; the fault of a print
/// takes a button.
Status PrinterDaemon::serve_fault() {
  while (!ending_) {
    const auto answer = ask([] {});
    PLUMBLINE_TRY(answer);
    const bool button = *answer == EventKind::kStartPressed || *answer == EventKind::kCancelPressed;
    if (!button && !plate_.is_empty()) continue;
    served_ = *answer == EventKind::kCancelPressed;
    apply(PrintEvent::kAcknowledged);
    break;
  }
  return {};
}

Status PrinterDaemon::serve_stick() {
  served_ = true;
  fault_ = FaultCode::kNone;
  record_.begin_job();
  apply(PrintEvent::kJobOffered);
  return print_scan();
}

/// Carries out a command. One that answers a question becomes the button that does.
Expected<std::optional<EventKind>> PrinterDaemon::take(const ClientRequest& request) {
  if (const auto button = button_of(request.command)) {
    by_command_ = true;
    return button;
  }
  if (offer_ == nullptr) return fail(ErrorCode::kBadSetting, "nothing is offered");
  if (request.command == Command::kSet) {
    PLUMBLINE_TRY(set(*offer_, request.key.view(), request.value.view()));
    return std::nullopt;
  }
  if (request.scan > offer_->choices()) {
    return fail(ErrorCode::kBadSetting, "there is no scan %u on the stick: it has %zu", request.scan,
                offer_->choices());
  }
  choose_scan(*offer_, request.scan - 1);
  return std::nullopt;
}

/// What a stick has, before anybody chooses.
Status PrinterDaemon::make_offer(const StickMount& mount, Offer& offer) {
  const auto scans = list_scans(mount);
  PLUMBLINE_TRY(scans);
  offer.scans = *scans;
  record_scans(*scans);
  if (offer.has_job_file()) {
    auto file = mount.open(scans->job_file.view());
    PLUMBLINE_TRY(file);
    auto read = slicing_.read_job(mount, *file);
    ending_ = ending_ || slicing_.shutdown();
    PLUMBLINE_TRY(read);
    offer.job = std::move(*read);
  } else if (scans->count == 0) {
    return fail(ErrorCode::kNoPoints,
                "there is no scan on the stick:\tput a PLY, PCD, OBJ or XYZ file in its top folder");
  } else {
    offer.job.scan = scans->list[0].name.view();
  }
  record_job(offer);
  return {};
}

void PrinterDaemon::show(const Offer& offer) {
  const bool several = offer.choices() > 1;
  FixedText<400> text;
  if (several) text.add("scan %zu of %zu: ", offer.chosen + 1, offer.choices());
  text.add("%s%s%s. Press start to print it%s", offer.scans.job_file.c_str(), offer.has_job_file() ? " asks for " : "",
           offer.job.scan.c_str(), several ? ", pause for the next one, cancel for none" : "");
  observer_.say(text.view());
}

/// @pre scan < offer.choices()
void PrinterDaemon::choose_scan(Offer& offer, std::size_t scan) {
  if (offer.choices() == 1) return;
  offer.chosen = scan;
  offer.job.scan = offer.scans.list[scan].name.view();
  record_job(offer);
  show(offer);
}

Status PrinterDaemon::set(Offer& offer, std::string_view key, std::string_view value) {
  if (key == "profile") {
    const auto profile = profile_of(std::string(value));
    PLUMBLINE_TRY(profile);
    offer.job.profile = value;
  } else {
    PLUMBLINE_TRY(set_job_setting(offer.job, key, value));
  }
  record_job(offer);
  return {};
}

/// Lists the scans of a stick. What was wrong with one of them is remembered as long as the stick is in.
void PrinterDaemon::record_scans(const StickScans& scans) {
  const auto before = record_.scans;
  const std::size_t count_before = record_.scan_count;
  record_.has_job_file = !scans.job_file.view().empty();
  record_.scan_count = scans.count;
  record_.scans_left_out = scans.left_out;
  for (std::size_t i = 0; i < scans.count; ++i) {
    ScanRecord& scan = record_.scans[i];
    scan = {};
    assign(scan.name, scans.list[i].name.view());
    scan.bytes = scans.list[i].bytes;
    if (scan.bytes == 0) assign(scan.problem, "the file is empty");
    for (std::size_t k = 0; k < count_before; ++k) {
      if (before[k].name.view() == scan.name.view() && before[k].bytes == scan.bytes) scan.problem = before[k].problem;
    }
  }
}

void PrinterDaemon::record_job(const Offer& offer) {
  const StickJob& job = offer.job;
  JobRecord& record = record_.job.emplace();
  assign(record.scan, job.scan);
  assign(record.profile, job.profile.empty() ? settings_.machine.profile : job.profile);
  if (!offer.has_job_file()) record.chosen = offer.chosen;
  record.units = job.units;
  record.scale = job.scale;
  record.fit = job.fit;
  record.size = job.size;
  record.orient = job.orient;
  record.floor = job.floor;
  record.rotate_deg = {job.rotate_x_deg, job.rotate_y_deg, job.rotate_z_deg};
  record.layer_height_mm = job.layer_height;
  record.supports = job.supports;
  record.base = job.base;
  record.keep_all = job.keep_all;
}

/// @returns the job that somebody wants printed; none: nobody does, or the stick was pulled
Expected<std::optional<StickJob>> PrinterDaemon::choose(const StickMount& mount) {
  Offer offer;
  PLUMBLINE_TRY(make_offer(mount, offer));
  if (offer.choices() == 1 && settings_.machine.start == StartChoice::kOnStick) return offer.job;
  show(offer);
  offer_ = &offer;
  std::optional<StickJob> wanted;
  Status asked;
  while (!ending_) {
    const auto answer = ask([&] { choose_scan(offer, (offer.chosen + 1) % offer.choices()); });
    if (!answer) {
      asked = tl::unexpected<Error>(answer.error());
      break;
    }
    if (*answer == EventKind::kStickArrived) continue;  // the one that is read
    if (*answer == EventKind::kStartPressed) {
      wanted = offer.job;
    } else {
      served_ = *answer != EventKind::kStickDeparted;
    }
    break;
  }
  offer_ = nullptr;
  PLUMBLINE_TRY(asked);
  return wanted;
}

Expected<PrintProfile> PrinterDaemon::profile_of(const std::string& name) const {
  // A name, not a path: a stick must not reach the printer's files.
  auto profile = read_print_profile(name.empty() ? settings_.machine.profile : name, settings_.board_path);
  if (!profile) return tl::unexpected<Error>(as_setting_error(profile.error()));
  return profile;
}

/// Says what the checks of the masks have found. Asks whether to print it all the same, if the profile wants that.
/// @returns whether to print it. If not, the state says why
Expected<bool> PrinterDaemon::accept_issues(const StackFindings& findings, const PrintGrid& grid,
                                            const CheckPolicy& policy) {
  for_each_issue(findings, grid, policy, [&](IssueKind, CheckAction, std::string_view sentence) {
    observer_.say(sentence);
    record_.add_finding(Severity::kWarning, sentence);
  });
  const CheckAction action = verdict(findings, policy);
  if (action == CheckAction::kRefuse) {
    refuse(judge(findings, grid, policy).error(), FaultCode::kIssueFound);
    return false;
  }
  if (action != CheckAction::kAsk) return true;
  apply(PrintEvent::kJobOffered);
  FixedText<400> text;
  text.add("found in the layers: %s. Press start to print it all the same, or cancel", issue_counts(findings).c_str());
  observer_.say(text.view());
  while (!ending_) {
    const auto answer = ask([] {});
    PLUMBLINE_TRY(answer);
    if (*answer == EventKind::kStartPressed) {
      apply(PrintEvent::kJobTaken);
      return true;
    }
    if (*answer == EventKind::kCancelPressed) break;
  }
  apply(PrintEvent::kCancelAsked);
  return false;
}

Status PrinterDaemon::print_scan() {
  PrintSession session(settings_.board, settings_.machine, arena_, &store_);
  std::optional<PrintProfile> profile;
  std::optional<CheckedAnswer> answer;
  FixedText<256> name;
  {
    const auto mount = machine_.stick.mount();
    PLUMBLINE_TRY(mount);
    const auto wanted = choose(*mount);
    PLUMBLINE_TRY(wanted);
    if (!*wanted) {
      apply(PrintEvent::kCancelAsked);
      return {};
    }
    const StickJob& job = **wanted;
    auto read = profile_of(job.profile);
    PLUMBLINE_TRY(read);
    profile = std::move(*read);
    auto scan = mount->open(job.scan);
    PLUMBLINE_TRY(scan);
    apply(PrintEvent::kJobTaken);
    FixedText<400> text;
    text.add("reading %s, profile %s", job.scan.c_str(), profile->name.c_str());
    observer_.say(text.view());
    ScanRequest request;
    request.name.add("%s", job.scan.c_str());
    request.size = scan->size();
    request.settings.threads = settings_.threads;
    request.settings.base = job.base;
    request.settings.floor = job.floor;
    request.settings.orient = job.orient;
    request.settings.keep_all = job.keep_all;
    PlacementSettings& placement = request.settings.placement;
    placement.units = job.units;
    placement.scale = job.scale;
    placement.fit = job.fit;
    placement.size = job.size;
    placement.rotation_degrees = {job.rotate_x_deg, job.rotate_y_deg, job.rotate_z_deg};
    placement.layer_height_mm = static_cast<float>(job.layer_height > 0 ? job.layer_height : profile->layer_height);
    placement.printer = printer_volume(settings_.board);
    const auto supports = SupportChoice{job.supports, {}}.over(profile->supports_enable, profile->supports);
    PLUMBLINE_TRY(supports);
    request.supports = *supports;
    if (*supports) placement.room = support_room(**supports);
    // Checks that don't depend on the height run before slicing, which may take minutes.
    PLUMBLINE_TRY(plan_print(*profile, settings_.machine, static_cast<double>(placement.layer_height_mm), 1));
    const auto sliced = slicing_.run(*mount, *scan, request);
    ending_ = ending_ || slicing_.shutdown();
    PLUMBLINE_TRY(sliced);
    answer = *sliced;
    name = request.name;
    for (std::size_t i = 0; i < answer->remarks; ++i) {
      const auto remark = in_stick_words(answer->remark[i].view());
      observer_.say(remark.view());
      record_.add_finding(Severity::kWarning, remark.view());
    }
  }
  observer_.say("the stick may be pulled");
  const auto wanted = accept_issues(answer->sliced.findings, answer->sliced.rrep.grid, profile->checks);
  PLUMBLINE_TRY(wanted);
  if (!*wanted) return {};
  PLUMBLINE_TRY(session.take(answer->sliced, name.view(), *profile));
  apply(PrintEvent::kSliced);
  print(session, *profile);
  return {};
}

Status PrinterDaemon::resume() {
  PrintSession session(settings_.board, settings_.machine, arena_, &store_);
  const auto loaded = session.load();
  if (!loaded) {
    const bool another = loaded.error().code() == ErrorCode::kUnsupported;
    refuse(loaded.error(), another ? FaultCode::kJournalOfAnother : FaultCode::kJournalDamaged);
    return {};
  }
  auto profile = profile_of(std::string(view(session.facts().profile)));
  PLUMBLINE_TRY(profile);
  record_.begin_job();
  JobRecord& job = record_.job.emplace();
  assign(job.scan, view(session.facts().scan));
  assign(job.profile, view(session.facts().profile));
  apply(PrintEvent::kJobResumed);
  print(session, *profile);
  return {};
}

void PrinterDaemon::print(PrintSession& session, const PrintProfile& profile) {
  record_.resin = ResinRecord{static_cast<double>(session.facts().cured_pixels) * session.pixel_ml(),
                              settings_.machine.tank_volume_ml};
  record_.slicing.reset();
  const PrintReport& report = session.print(machine_, observer_, &plate_);
  observer_.printed(report, session, profile);
  // Don't print the same stick again until it is plugged in anew.
  served_ = machine_.stick.has_stick();
  fault_ = report.fault;
  if (report.state == PrintState::kFault) {
    apply(PrintEvent::kFailed);
  } else if (report.state == PrintState::kSuspended) {
    apply(PrintEvent::kShutdown);
    ending_ = true;
  } else {
    // Finished, or cancelled by the user: settle() asks for the plate either way.
    apply(PrintEvent::kCancelAsked);
    apply(PrintEvent::kAcknowledged);
  }
}

/// Says why a job could not be printed, or that the user stopped it.
void PrinterDaemon::refuse(const Error& error, FaultCode code) {
  record_.slicing.reset();
  if (error.code() == ErrorCode::kCancelled) {
    apply(PrintEvent::kCancelAsked);
    apply(PrintEvent::kAcknowledged);
    observer_.say(ending_ ? "reading stopped" : "cancelled");
    return;
  }
  fault_ = code;
  apply(PrintEvent::kFailed);
  const FaultText fault = explain(fault_, error.finding(), error.advice());
  auto advice = in_stick_words(fault.advice.view());
  if (advice.view().find("--") != std::string_view::npos) {
    // The advice names an option that job.toml does not have.
    advice.clear();
    advice.add("%.*s", static_cast<int>(info(fault_).next.size()), info(fault_).next.data());
  }
  record_.set_fault(fault_, error.finding(), advice.view());
  if (record_.job && record_.job->chosen && *record_.job->chosen < record_.scan_count) {
    assign(record_.scans[*record_.job->chosen].problem, fault.what.view());
  }
  FixedText<1000> text;
  text.add("%s. %s", fault.what.c_str(), advice.c_str());
  observer_.say(text.view());
}

}  // namespace plumbline
