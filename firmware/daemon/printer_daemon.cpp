#include "firmware/daemon/printer_daemon.hpp"

#include <utility>

#include "firmware/daemon/stick_words.hpp"
#include "firmware/print/status/state_lights.hpp"
#include "firmware/settings/support_choice.hpp"
#include "slicer/support_building.hpp"

namespace plumbline {
namespace {

/// How long the daemon waits for an event before its next turn. Shorter responds faster, longer spares the processor.
constexpr nanoseconds kLook = std::chrono::milliseconds(200);

/// A press this soon after a question answers the one before it: whoever presses start twice must not print onto a full plate.
constexpr nanoseconds kSettle = std::chrono::seconds(1);

}  // namespace

PrinterDaemon::PrinterDaemon(Machine& machine, const DaemonSettings& settings, SlicingChild& child, Arena& arena,
                             JobStore& store, PlateRecord& plate, DaemonObserver& observer)
    : machine_(machine),
      settings_(settings),
      child_(child),
      arena_(arena),
      store_(store),
      plate_(plate),
      observer_(observer),
      slicing_(child, machine, arena, observer, settings.slicing_patience) {}

void PrinterDaemon::apply(PrintEvent event) {
  const PrintState before = state_;
  state_ = next(state_, event);
  if (state_ == before) return;
  if (state_ == PrintState::kIdle) told_ready_ = false;
  show_on_panel(machine_.panel, state_);
}

Status PrinterDaemon::run() {
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
  const auto event = machine_.events.next_event(machine_.clock.now() + kLook);
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
    const auto event = machine_.events.next_event(machine_.clock.now() + kLook);
    PLUMBLINE_TRY(event);
    observer_.idle();
    if (!*event) continue;
    const EventKind kind = (*event)->kind;
    switch (kind) {
      case EventKind::kStartPressed:
      case EventKind::kCancelPressed:
        if ((*event)->at < asked + kSettle) break;
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
  apply(PrintEvent::kJobOffered);
  return print_scan();
}

/// @returns the job that somebody wants printed; none: nobody does, or the stick was pulled
Expected<std::optional<StickJob>> PrinterDaemon::choose(const StickMount& mount) {
  const auto scans = list_scans(mount);
  PLUMBLINE_TRY(scans);
  StickJob job;
  const bool has_job_file = !scans->job_file.view().empty();
  if (has_job_file) {
    auto file = mount.open(scans->job_file.view());
    PLUMBLINE_TRY(file);
    auto read = slicing_.read_job(mount, *file);
    ending_ = ending_ || slicing_.shutdown();
    PLUMBLINE_TRY(read);
    job = std::move(*read);
  } else if (scans->count == 0) {
    return fail(ErrorCode::kNoPoints,
                "there is no scan on the stick:\tput a PLY, PCD, OBJ or XYZ file in its top folder");
  } else {
    job.scan = scans->names[0].view();
  }
  const std::size_t choices = has_job_file ? 1 : scans->count;
  if (choices == 1 && settings_.machine.start == StartChoice::kOnStick) return job;

  std::size_t chosen = 0;
  const auto show = [&] {
    FixedText<400> text;
    if (choices > 1) text.add("scan %zu of %zu: ", chosen + 1, choices);
    text.add("%s%s%s. Press start to print it%s", scans->job_file.c_str(), has_job_file ? " asks for " : "",
             job.scan.c_str(), choices > 1 ? ", pause for the next one, cancel for none" : "");
    observer_.say(text.view());
  };
  const auto show_next = [&] {
    if (choices == 1) return;
    chosen = (chosen + 1) % choices;
    job.scan = scans->names[chosen].view();
    show();
  };
  show();
  while (!ending_) {
    const auto answer = ask(show_next);
    PLUMBLINE_TRY(answer);
    if (*answer == EventKind::kStartPressed) return job;
    if (*answer == EventKind::kStickArrived) continue;  // the one that is read
    served_ = *answer != EventKind::kStickDeparted;
    break;
  }
  return std::nullopt;
}

Expected<PrintProfile> PrinterDaemon::profile_of(const std::string& name) const {
  // A name, not a path: a stick must not reach the printer's files.
  auto profile = read_print_profile(name.empty() ? settings_.machine.profile : name, settings_.board_path);
  if (!profile) return tl::unexpected<Error>(as_setting_error(profile.error()));
  return profile;
}

Status PrinterDaemon::print_scan() {
  PrintSession session(settings_.board, settings_.machine, arena_, &store_);
  std::optional<PrintProfile> profile;
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
    request.settings.keep_all = job.keep_all;
    PlacementSettings& placement = request.settings.placement;
    placement.units = job.units;
    placement.scale = job.scale;
    placement.fit = job.fit;
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
    for (std::size_t i = 0; i < sliced->remarks; ++i) observer_.say(in_stick_words(sliced->remark[i].view()).view());
    PLUMBLINE_TRY(session.take(sliced->sliced, request.name.view(), *profile));
  }
  observer_.say("the stick may be pulled");
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
  apply(PrintEvent::kJobResumed);
  print(session, *profile);
  return {};
}

void PrinterDaemon::print(PrintSession& session, const PrintProfile& profile) {
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
  FixedText<1000> text;
  text.add("%s. %s", fault.what.c_str(), advice.c_str());
  observer_.say(text.view());
}

}  // namespace plumbline
