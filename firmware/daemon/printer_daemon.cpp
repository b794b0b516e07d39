#include "firmware/daemon/printer_daemon.hpp"

#include <algorithm>

#include "firmware/daemon/stick_words.hpp"
#include "firmware/settings/support_choice.hpp"
#include "firmware/slice/job_report.hpp"

namespace plumbline {
namespace {

/// How long the daemon waits for an event before its next turn. Shorter responds faster, longer spares the processor.
constexpr nanoseconds kLook = std::chrono::milliseconds(200);

/// Reads the buttons while a scan is read and sliced.
class SliceButtons final : public ProgressSink {
 public:
  explicit SliceButtons(Machine& machine) : machine_(machine) {}

  void begin(Stage /*stage*/) override {}
  bool advance(Stage /*stage*/, double /*fraction*/) override {
    for (;;) {
      const auto event = machine_.events.next_event(machine_.clock.now());
      if (!event || !*event) break;
      if ((*event)->kind == EventKind::kCancelPressed) cancelled_ = true;
      if ((*event)->kind == EventKind::kShutdownRequested) shutdown_ = true;
    }
    return !cancelled_ && !shutdown_;
  }
  void end(Stage /*stage*/, std::size_t /*peak_bytes*/) override {}
  bool shutdown() const { return shutdown_; }

 private:
  Machine& machine_;
  bool cancelled_ = false;
  bool shutdown_ = false;
};

}  // namespace

PrinterDaemon::PrinterDaemon(Machine& machine, const DaemonSettings& settings, Arena& arena, JobStore& store,
                             DaemonObserver& observer)
    : machine_(machine), settings_(settings), arena_(arena), store_(store), observer_(observer) {}

void PrinterDaemon::apply(PrintEvent event) {
  state_ = next(state_, event);
  const auto on_if = [](bool on) { return on ? LightState::kOn : LightState::kOff; };
  // A failed light is no reason to refuse a job.
  static_cast<void>(machine_.panel.set_light(PanelLight::kReady, on_if(state_ == PrintState::kIdle)));
  static_cast<void>(machine_.panel.set_light(PanelLight::kFault, on_if(state_ == PrintState::kFault)));
  static_cast<void>(machine_.panel.set_light(
      PanelLight::kPrinting, state_ == PrintState::kSlicing ? LightState::kBlinking : LightState::kOff));
}

Status PrinterDaemon::run() {
  apply(PrintEvent::kAcknowledged);
  observer_.say("ready");
  while (!ending_) {
    const auto served = serve();
    if (served) continue;
    if (served.error().code() == ErrorCode::kPowerLost) return served;
    PLUMBLINE_TRY(refuse(served.error(), fault_of(served.error().code())));
  }
  observer_.say("shut down");
  return {};
}

Status PrinterDaemon::serve() {
  if (store_.has_job() && state_ != PrintState::kFault) return serve_interrupted();
  if (machine_.stick.has_stick() && !served_) return serve_stick();
  const auto event = machine_.events.next_event(machine_.clock.now() + kLook);
  PLUMBLINE_TRY(event);
  observer_.idle();
  if (!*event) return {};
  switch ((*event)->kind) {
    case EventKind::kShutdownRequested: ending_ = true; return {};
    case EventKind::kStickArrived:
    case EventKind::kStickDeparted:
    case EventKind::kStartPressed:  // print it again
      served_ = false;
      apply(PrintEvent::kAcknowledged);
      return {};
    case EventKind::kCancelPressed: apply(PrintEvent::kAcknowledged); return {};
    case EventKind::kPausePressed:
    case EventKind::kCoverOpened:
    case EventKind::kCoverClosed:
    case EventKind::kExposureEnded:
    case EventKind::kMotionEnded: return {};
  }
  return {};
}

/// Waits for a button. Pause means "the next one".
Expected<PrinterDaemon::Choice> PrinterDaemon::ask(const std::function<void()>& on_next) {
  static_cast<void>(machine_.panel.set_light(PanelLight::kAttention, LightState::kBlinking));
  std::optional<Choice> choice;
  while (!choice) {
    const auto event = machine_.events.next_event(machine_.clock.now() + kLook);
    PLUMBLINE_TRY(event);
    observer_.idle();
    if (!*event) continue;
    switch ((*event)->kind) {
      case EventKind::kStartPressed: choice = Choice::kStart; break;
      case EventKind::kCancelPressed: choice = Choice::kCancel; break;
      case EventKind::kPausePressed: on_next(); break;
      case EventKind::kStickDeparted: choice = Choice::kStickGone; break;
      case EventKind::kShutdownRequested: choice = Choice::kShutdown; break;
      case EventKind::kStickArrived:
      case EventKind::kCoverOpened:
      case EventKind::kCoverClosed:
      case EventKind::kExposureEnded:
      case EventKind::kMotionEnded: break;
    }
  }
  static_cast<void>(machine_.panel.set_light(PanelLight::kAttention, LightState::kOff));
  if (*choice == Choice::kShutdown) ending_ = true;
  return *choice;
}

/// A print was interrupted and its part hangs in the printer, so nothing moves until the user decides.
Status PrinterDaemon::serve_interrupted() {
  observer_.say("an interrupted print can go on: press start to resume it, or cancel to give it up");
  auto choice = Choice::kStickGone;
  while (choice == Choice::kStickGone) {
    const auto asked = ask([] {});
    PLUMBLINE_TRY(asked);
    choice = *asked;
  }
  if (choice == Choice::kCancel) return store_.end();
  return choice == Choice::kStart ? resume() : Status();
}

Status PrinterDaemon::serve_stick() {
  served_ = true;
  fault_ = FaultCode::kNone;
  apply(PrintEvent::kJobTaken);
  return print_scan();
}

Expected<StickJob> PrinterDaemon::choose(const StickMount& mount) {
  const auto scans = list_scans(mount);
  PLUMBLINE_TRY(scans);
  if (scans->has_job_file) return read_stick_job(mount);
  if (scans->count == 0) {
    return fail(ErrorCode::kNoPoints,
                "there is no scan on the stick:\tput a PLY, PCD, OBJ or XYZ file in its top folder");
  }
  std::size_t chosen = 0;
  if (scans->count > 1) {
    const auto show = [&] {
      FixedText<400> text;
      text.add("scan %zu of %zu: %s. Press start to print it, pause for the next one, cancel for none", chosen + 1,
               scans->count, scans->names[chosen].c_str());
      observer_.say(text.view());
    };
    show();
    const auto choice = ask([&] {
      chosen = (chosen + 1) % scans->count;
      show();
    });
    PLUMBLINE_TRY(choice);
    if (*choice == Choice::kStickGone)
      return fail(ErrorCode::kStickGone, "the stick was pulled before a scan was chosen");
    if (*choice != Choice::kStart) return fail(ErrorCode::kCancelled, "no scan was chosen");
  }
  StickJob job;
  job.scan = scans->names[chosen].view();
  return job;
}

Expected<PrintProfile> PrinterDaemon::profile_of(const std::string& name) const {
  // A name, not a path: a stick must not reach the printer's files.
  return read_print_profile(name.empty() ? settings_.machine.profile : name, settings_.board_path);
}

Status PrinterDaemon::print_scan() {
  PrintSession session(settings_.board, settings_.machine, arena_, &store_);
  std::optional<PrintProfile> profile;
  {
    const auto mount = machine_.stick.mount();
    PLUMBLINE_TRY(mount);
    const auto job = choose(*mount);
    PLUMBLINE_TRY(job);
    auto read = profile_of(job->profile);
    PLUMBLINE_TRY(read);
    profile = std::move(*read);
    auto scan = mount->open(job->scan);
    PLUMBLINE_TRY(scan);
    FixedText<400> text;
    text.add("reading %s, profile %s", job->scan.c_str(), profile->name.c_str());
    observer_.say(text.view());
    SliceSettings settings;
    settings.threads = settings_.threads;
    settings.base = job->base;
    settings.keep_all = job->keep_all;
    PlacementSettings& placement = settings.placement;
    placement.units = job->units;
    placement.scale = job->scale;
    placement.fit = job->fit;
    placement.rotation_degrees = {job->rotate_x_deg, job->rotate_y_deg, job->rotate_z_deg};
    placement.layer_height_mm = static_cast<float>(job->layer_height > 0 ? job->layer_height : profile->layer_height);
    placement.printer = printer_volume(settings_.board);
    const auto supports = SupportChoice{job->supports, {}}.over(profile->supports_enable, profile->supports);
    PLUMBLINE_TRY(supports);
    SliceButtons buttons(machine_);
    const auto sliced = session.slice_scan(*scan, settings, *supports, *profile, &buttons);
    if (buttons.shutdown()) ending_ = true;
    PLUMBLINE_TRY(sliced);
    for_each_remark(session.sliced(), [&](std::string_view warning) { observer_.say(in_stick_words(warning).view()); });
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
    return refuse(loaded.error(), another ? FaultCode::kJournalOfAnother : FaultCode::kJournalDamaged);
  }
  auto profile = profile_of(std::string(view(session.facts().profile)));
  PLUMBLINE_TRY(profile);
  apply(PrintEvent::kJobResumed);
  print(session, *profile);
  return {};
}

void PrinterDaemon::print(PrintSession& session, const PrintProfile& profile) {
  const PrintReport& report = session.print(machine_, observer_);
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
    // Finished, or cancelled by the user: ready for the next job either way.
    apply(PrintEvent::kCancelAsked);
    apply(PrintEvent::kAcknowledged);
    observer_.say("ready");
  }
}

/// Says why a job could not be printed. The printer is ready for the next one.
Status PrinterDaemon::refuse(const Error& error, FaultCode code) {
  if (error.code() == ErrorCode::kCancelled) {
    apply(PrintEvent::kCancelAsked);
    apply(PrintEvent::kAcknowledged);
    observer_.say(ending_ ? "reading stopped" : "cancelled; ready");
    return {};
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
  return machine_.panel.beep(std::chrono::seconds(1));
}

}  // namespace plumbline
