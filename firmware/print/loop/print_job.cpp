#include "firmware/print/loop/print_job.hpp"

#include <algorithm>
#include <utility>

#include "firmware/messages/printer_code.hpp"
#include "firmware/print/loop/layer_checks.hpp"
#include "firmware/print/loop/plate_moves.hpp"
#include "firmware/print/loop/print_checks.hpp"
#include "firmware/print/loop/print_watch.hpp"
#include "firmware/print/loop/resume_check.hpp"
#include "firmware/print/loop/tank_fill.hpp"
#include "firmware/print/status/print_state.hpp"

namespace plumbline::firmware {
namespace {

/// How often a waiting print reads its switches and updates its observer. Shorter responds faster, longer spares the processor.
constexpr auto kLook = std::chrono::milliseconds(200);
/// Left of an exposure when its observer may look at the next mask. A core of x86-64 makes a picture of the largest panel in 6 ms; a board
/// may take many times as long.
constexpr auto kTimeToLook = std::chrono::milliseconds(300);
/// How often temperatures and fans are looked at while the print waits for them, which takes minutes.
constexpr auto kCoolingLook = std::chrono::seconds(2);
/// How long all must be well before it goes on: a fan that turns now and then is none.
constexpr auto kSteady = std::chrono::seconds(10);
/// How long it waits before it asks a person. Resin that is warmed takes half an hour.
constexpr auto kLongWait = std::chrono::hours(1);

/// Whether a mask could not be made although the panel works. The layer below cures whole; the mask is tried again before its own light.
bool is_of_mask(ErrorCode code) {
  return code == ErrorCode::kMalformed || code == ErrorCode::kUnsupported || code == ErrorCode::kCannotRead ||
         code == ErrorCode::kOutOfMemory;
}

/// One print, run once.
class PrintJob {
 public:
  PrintJob(Machine& machine, const PrintSettings& settings, MaskRenderer& masks, Journal* journal,
           MachineRecord& record, std::span<ExposureLine> exposures, PrintObserver& observer)
      : machine_(machine), settings_(settings), masks_(masks), journal_(journal), record_(record), observer_(observer) {
    report_.room = exposures;
  }

  const PrintReport& run(const std::optional<JournalEntry>& from);

 private:
  /// A mask in the panel's free buffer, not presented yet.
  struct ReadyMask {
    std::uint32_t layer;
    MaskFacts facts;
    MaskBuffer buffer;
  };

  void apply(PrintEvent event);  ///< the one place that changes the state
  bool apply_pending();
  void go_on();
  void notify();
  void fault(FaultCode code, std::string_view finding, const Told& told = {});
  void fail_with(const Error& error) { fault(fault_of(error.code()), error.finding(), error.told()); }

  Status step();
  Status run_checks();
  Status home();
  void confirm_journal();
  Status print_layer();
  bool is_ready(std::uint32_t layer) const;
  Status render(std::uint32_t layer, nanoseconds lit);
  bool needs_resin() const;
  void ask_for_resin();
  void note_use();
  Expected<LayerFinding> look_at_machine(bool waits);
  Expected<bool> cure_layer();
  Expected<bool> expose(const MaskFacts& shown);
  Status render_next(const MaskFacts& shown, const Exposure& exposure);
  Status layer_cured(const MaskFacts& shown);
  void record(const ExposureReport& exposure, const MaskFacts& shown);
  Status write_journal();
  Status write_spare();
  Status note_stand();
  Expected<bool> raise_for_pause();
  Status raise_to_pause();
  Status raise_to_end();
  Status wait_to_raise();
  Status wait_for_start();
  Status wait_for_cover();
  Status cool_down();
  void make_safe();

  double used_ml() const {
    return static_cast<double>(entry_.cured_pixels) * settings_.pixel_ml +
           (entry_.next_layer > 0 ? settings_.first_layer_more_ml : 0);
  }
  /// Of the layer whose mask is ready; 0: none is.
  double layer_ml() const { return ready_ ? static_cast<double>(ready_->facts.pixels) * settings_.pixel_ml : 0; }
  double left_to_print_ml() const { return settings_.needed_ml() - used_ml(); }
  /// The next layer to cure, or the last one if all are cured.
  std::uint32_t layer_at_hand() const {
    return entry_.next_layer < plan_.layers ? entry_.next_layer : plan_.layers - 1;
  }
  /// From now on the print has `left` to go, of which `after` follows what it does next.
  void expect(nanoseconds left, nanoseconds after) {
    ends_at_ = machine_.clock.now() + left;
    left_after_ = after;
  }
  nanoseconds time_left();
  nanoseconds elapsed() const { return machine_.clock.now() - began_; }

  Machine& machine_;
  const PrintSettings settings_;
  const PrintPlan& plan_ = settings_.plan;
  MaskRenderer& masks_;
  Journal* journal_;
  MachineRecord& record_;
  PrintObserver& observer_;
  PrintReport report_;

  PrintState state_ = PrintState::kIdle;
  PrintWatch watch_{machine_, state_, [this] { notify(); }};
  PlateMoves plate_{machine_.stage, plan_, watch_};
  PrintChecks checks_{machine_, settings_, report_.checks, observer_};
  JournalEntry entry_;  ///< the next entry for the journal, as of now
  /// The journal that is resumed from may lack layers: neither the stage nor the user has confirmed it yet. Not a state, since a print can
  /// be suspended, fail or be cancelled in doubt, and must not write to the journal then.
  bool in_doubt_ = false;
  bool at_hand_lit_ = false;  ///< the layer at hand may have had light
  std::optional<ReadyMask> ready_;
  std::optional<nanoseconds> slack_;  ///< of the mask that was rendered during the last exposure
  TimePoint began_;                   ///< when it would have begun without its interruptions
  TimePoint ends_at_;                 ///< as expect() was told
  nanoseconds left_after_{};
  nanoseconds told_left_ = nanoseconds::max();  ///< by time_left()
  Spoken question_;                             ///< that the start button answers; empty: the state's own question
  LayerFinding hindrance_;                      ///< what the print waits for in kCoolingDown
  bool tank_is_looked_at_ = false;
  double fill_ml_ = 0;              ///< that the tank is to hold when start is pressed
  std::uint32_t fills_before_ = 0;  ///< MachineRecord::fills() when the print asked for it
};

const PrintReport& PrintJob::run(const std::optional<JournalEntry>& from) {
  in_doubt_ = from.has_value();
  entry_ = from.value_or(JournalEntry());
  const TimePoint began = machine_.clock.now();
  began_ = began - entry_.elapsed;
  report_.layers = plan_.layers;
  report_.first_layer = entry_.next_layer;
  report_.estimated = print_time(plan_) - (remaining_time(plan_, 0) - remaining_time(plan_, entry_.next_layer));
  // Whatever ended the run before may have lit the layer at hand.
  at_hand_lit_ = entry_.at_hand_pixels > 0;
  const nanoseconds after_homing = time_to_end(plan_, plan_.highest, entry_.next_layer, entry_.lit);
  // Where the plate stands is not known before the end stop is found: it may be far below.
  const auto at = machine_.stage.position();
  expect(homing_time(plan_, at.value_or(ZPosition())) + after_homing, after_homing);
  apply(PrintEvent::kJobResumed);
  while (!at_rest(state_)) {
    const auto done = step();
    if (!done) fail_with(done.error());
  }
  make_safe();
  report_.state = state_;
  report_.next_layer = entry_.next_layer;
  report_.cured_pixels = entry_.cured_pixels;
  report_.resin_ml = used_ml();
  report_.elapsed = machine_.clock.now() - began;
  report_.steps_lost = plate_.steps_lost();
  return report_;
}

void PrintJob::apply(PrintEvent event) {
  const PrintState before = state_;
  state_ = next(state_, event);
  if (state_ == before) return;
  if (before == PrintState::kPrinting && is_pause(state_)) ++report_.pauses;
  if (waits_for_start(state_)) watch_.asks();
  if (state_ == PrintState::kPrinting) {
    const auto at = machine_.stage.position();
    expect(time_to_end(plan_, at.value_or(plan_.highest), entry_.next_layer, entry_.lit), {});
  }
  show_on_panel(machine_.panel, state_);
  notify();
}

/// Turns the pending request into a change of state. @returns true: the state has changed
bool PrintJob::apply_pending() {
  const PrintState before = state_;
  switch (watch_.take()) {
    case Request::kShutdown: apply(PrintEvent::kShutdown); break;
    case Request::kCancel: apply(PrintEvent::kCancelAsked); break;
    case Request::kCoverOpened: apply(PrintEvent::kCoverOpened); break;
    case Request::kPause: apply(PrintEvent::kPauseAsked); break;
    case Request::kResume: go_on(); break;
    case Request::kNone: break;
  }
  return state_ != before;
}

/// Resumes when start is pressed. With the cover open the lamp can't light, so it only beeps.
void PrintJob::go_on() {
  if (machine_.panel.cover_open()) {
    static_cast<void>(machine_.panel.beep(std::chrono::milliseconds(200)));
    return;
  }
  // Whoever fills the tank and says how far has answered already.
  if (state_ == PrintState::kFeedMe && record_.fills() == fills_before_) {
    if (const auto filled = record_.fill(fill_ml_); !filled) return fail_with(filled.error());
  }
  if (!question_.text.view().empty()) in_doubt_ = false;  // it was about the part, or the journal is confirmed already
  question_ = {};
  apply(PrintEvent::kResumeAsked);
}

void PrintJob::notify() {
  PrintStatus status;
  status.state = state_;
  const bool may_pause =
      state_ == PrintState::kChecks || state_ == PrintState::kHoming || state_ == PrintState::kPrinting;
  if (watch_.pending() == Request::kPause && may_pause) status.note = PrintNote::kPauseTaken;
  if (is_raise_to_end(state_) && machine_.panel.cover_open()) status.note = PrintNote::kCoverFirst;
  status.layer = entry_.next_layer;
  status.layers = plan_.layers;
  status.height = height_of(plan_, layer_at_hand());
  status.now = machine_.clock.now();
  status.elapsed = elapsed();
  status.remaining = time_left();
  status.slack = slack_;
  status.resin_ml = used_ml();
  Spoken question = question_;
  if (state_ == PrintState::kFeedMe) {
    question = fill_question(record_.resin_ml(), fill_ml_);
  } else if (state_ == PrintState::kCoolingDown) {
    question.text.add("%s. The print goes on by itself",
                      explain(hindrance_.fault, hindrance_.text.view()).what.c_str());
    question.told = hindrance_.told;
  }
  status.question = question.text.view();
  status.question_told = question.told;
  if (!observer_.update(status)) watch_.request(Request::kCancel);
}

/// Falls with the time, and never rises but for a pause.
nanoseconds PrintJob::time_left() {
  if (state_ == PrintState::kFinished || state_ == PrintState::kCancelled) return {};
  if (is_pause(state_)) {
    const auto at = machine_.stage.position();
    return told_left_ = time_to_end(plan_, at.value_or(plan_.highest), entry_.next_layer, entry_.lit);
  }
  return told_left_ = std::min(told_left_, std::max<nanoseconds>(ends_at_ - machine_.clock.now(), left_after_));
}

void PrintJob::fault(FaultCode code, std::string_view finding, const Told& told) {
  if (report_.fault == FaultCode::kNone) {
    report_.fault = code;
    report_.fault_message.add("%.*s", static_cast<int>(finding.size()), finding.data());
    report_.fault_told = told;
  }
  apply(code == FaultCode::kPowerLost ? PrintEvent::kShutdown : PrintEvent::kFailed);
}

Status PrintJob::step() {
  if (watch_.pending() >= Request::kCancel && apply_pending()) return {};
  switch (state_) {
    case PrintState::kChecks: return run_checks();
    case PrintState::kHoming: return home();
    case PrintState::kPrinting: return print_layer();
    case PrintState::kPausing: return raise_to_pause();
    case PrintState::kPaused:
    case PrintState::kFeedMe: return wait_for_start();
    case PrintState::kCoverOpen: return wait_for_cover();
    case PrintState::kCoolingDown: return cool_down();
    case PrintState::kCancelling:
    case PrintState::kFinishing: return raise_to_end();
    case PrintState::kSlicing:
    case PrintState::kIdle:
    case PrintState::kOffered:
    case PrintState::kInterrupted:
    case PrintState::kPlateInUse:
    case PrintState::kFinished:
    case PrintState::kCancelled:
    case PrintState::kSuspended:
    case PrintState::kFault: return {};
  }
  return {};
}

Status PrintJob::run_checks() {
  PLUMBLINE_TRY(checks_.run(masks_.grid(), entry_.cured_pixels, record_.resin_ml(), journal_ != nullptr));
  if (checks_.fault() != FaultCode::kNone) {
    fault(checks_.fault(), checks_.failed().detail.view(), checks_.failed().told);
    return {};
  }
  // From here on a part may be on the plate, whatever ends this program.
  PLUMBLINE_TRY(record_.begin_print(journal_ != nullptr ? journal_->job_hash() : 0,
                                    {settings_.pixel_ml, settings_.first_layer_more_ml}));
  report_.begun = true;
  PLUMBLINE_TRY(machine_.thermals.set_fan(Fan::kLamp, 1));
  PLUMBLINE_TRY(machine_.thermals.set_fan(Fan::kChamber, 1));
  // An interruption after the last layer shows nowhere.
  if (report_.first_layer > 0 && report_.first_layer < plan_.layers) report_.marked_layer = report_.first_layer;
  apply(PrintEvent::kChecksPassed);
  return {};
}

Status PrintJob::home() {
  const auto homed = plate_.home();
  if (!homed) {
    checks_.stage_failed(homed.error());
    return tl::unexpected<Error>(homed.error());
  }
  plate_.forget_steps_lost();  // lost before this print
  // Also if the user interrupts at the very end of the homing, since the plate can be lowered from here on.
  if (in_doubt_ && machine_.stage.homed()) confirm_journal();
  if (!*homed) {
    apply_pending();
    return {};
  }
  checks_.stage_homed();
  apply(in_doubt_ ? PrintEvent::kPartInDoubt : PrintEvent::kHomed);
  return {};
}

void PrintJob::confirm_journal() {
  const auto found = plate_.homed_from();
  in_doubt_ = !stage_confirms(entry_, plan_, found, machine_.stage.limits().drift);
  if (!in_doubt_) return;
  question_ = question_about(entry_);
  checks_.journal_in_doubt(doubt_about(entry_, found));
}

Status PrintJob::print_layer() {
  const std::uint32_t layer = entry_.next_layer;
  if (layer == plan_.layers) {
    apply(PrintEvent::kLastLayerDone);
    return {};
  }
  const TimePoint layer_began = machine_.clock.now();
  expect(time_to_end(plan_, machine_.stage.position().value_or(plan_.highest), layer, entry_.lit),
         time_to_end(plan_, lift_from(plan_, layer)[1].target, layer + 1));
  if (!std::exchange(tank_is_looked_at_, true) &&
      needs_filling(record_.resin_ml(), left_to_print_ml(), settings_.tank_ml)) {
    ask_for_resin();
    return {};
  }
  const auto found = look_at_machine(false);
  PLUMBLINE_TRY(found);
  if (found->fault != FaultCode::kNone) {
    hindrance_ = *found;
    apply(PrintEvent::kTooHot);
    return {};
  }
  if (!is_ready(layer)) {
    PLUMBLINE_TRY(render(layer, entry_.lit));
    observer_.mask_made(layer, masks_.mask());
  }
  if (needs_resin()) {
    ask_for_resin();
    return {};
  }
  const MaskFacts shown = ready_->facts;
  if (entry_.at_hand_pixels != shown.pixels) {
    // So that a power cut under its light is known to have used them.
    entry_.at_hand_pixels = static_cast<std::uint32_t>(shown.pixels);
    PLUMBLINE_TRY(write_spare());
  }
  const auto lowered = plate_.lower_to(layer);
  PLUMBLINE_TRY(lowered);
  if (*lowered) PLUMBLINE_TRY(watch_.wait(plan_.rest_before_exposure));
  if (watch_.pending() != Request::kNone) {
    apply_pending();
    return {};
  }
  const auto cured = cure_layer();
  PLUMBLINE_TRY(cured);
  PLUMBLINE_TRY(machine_.mask.blank());
  if (!*cured) {
    apply_pending();
    return {};
  }
  PLUMBLINE_TRY(layer_cured(shown));
  const nanoseconds took = machine_.clock.now() - layer_began;
  if (took > report_.slowest) {
    report_.slowest = took;
    report_.slowest_layer = layer;
  }
  notify();
  if (entry_.next_layer == plan_.layers && !watch_.interrupted()) {
    apply(PrintEvent::kLastLayerDone);
  } else {
    apply_pending();
  }
  return {};
}

/// Whether the mask is ready that a layer needs now.
bool PrintJob::is_ready(std::uint32_t layer) const {
  if (!ready_ || ready_->layer != layer) return false;
  const MaskFacts& facts = ready_->facts;
  return facts.begin <= entry_.lit && (entry_.lit < facts.end || facts.is_last);
}

/// @param lit  light that the layer will have had by then
Status PrintJob::render(std::uint32_t layer, nanoseconds lit) {
  ready_.reset();
  auto buffer = machine_.mask.lend();
  PLUMBLINE_TRY(buffer);
  const auto facts = masks_.render(layer, lit, buffer->image(), buffer->greys());
  PLUMBLINE_TRY(facts);
  ready_.emplace(ReadyMask{layer, *facts, std::move(*buffer)});
  return {};
}

/// Whether the tank has too little resin for the layer whose mask is ready.
bool PrintJob::needs_resin() const {
  if (at_hand_lit_) return false;  // its resin is cured already
  return layer_ml() > usable_ml(record_.resin_ml(), settings_.tank_ml);
}

void PrintJob::ask_for_resin() {
  fill_ml_ = fill_to_ml(std::max(left_to_print_ml(), layer_ml()), settings_.tank_ml);
  fills_before_ = record_.fills();
  apply(PrintEvent::kResinLow);
}

/// Temperatures and fans: what keeps the print from going on.
/// @param waits  it waits for that already
Expected<LayerFinding> PrintJob::look_at_machine(bool waits) {
  const auto temperatures = read_temperatures(machine_.thermals);
  PLUMBLINE_TRY(temperatures);
  for (std::size_t i = 0; i < temperatures->size(); ++i) {
    record_.felt(static_cast<TemperatureSite>(i), (*temperatures)[i]);
  }
  const LayerFinding found = check_temperatures(*temperatures, settings_, waits);
  return found.fault != FaultCode::kNone ? found : check_fans(machine_.thermals);
}

/// Tells the record what the print has used so far.
void PrintJob::note_use() {
  record_.note({.pixels = entry_.cured_pixels + (at_hand_lit_ ? entry_.at_hand_pixels : 0),
                .layers = entry_.next_layer,
                .lamp = entry_.lamp});
}

/// Shows the masks that the layer lacks, one after another. @returns false: interrupted before it had all its light
Expected<bool> PrintJob::cure_layer() {
  const std::uint32_t layer = entry_.next_layer;
  for (;;) {
    if (!is_ready(layer)) PLUMBLINE_TRY(render(layer, entry_.lit));
    const MaskFacts shown = ready_->facts;
    PLUMBLINE_TRY(machine_.mask.present(std::move(ready_->buffer)));
    ready_.reset();
    const auto exposed = expose(shown);
    PLUMBLINE_TRY(exposed);
    if (!*exposed || shown.is_last) return exposed;
    if (watch_.interrupted()) return false;
  }
}

/// Gives a mask the rest of its light. @returns false: interrupted before it had it
Expected<bool> PrintJob::expose(const MaskFacts& shown) {
  const nanoseconds cure = shown.end - entry_.lit;
  if (cure <= nanoseconds::zero()) return true;
  auto exposure = machine_.lamp.begin_exposure(cure);
  if (!exposure && exposure.error().code() == ErrorCode::kCoverOpen) {
    watch_.request(Request::kCoverOpened);
    return false;
  }
  PLUMBLINE_TRY(exposure);
  at_hand_lit_ = true;
  PLUMBLINE_TRY(render_next(shown, *exposure));
  PLUMBLINE_TRY(watch_.wait_for(*exposure));
  const auto report = exposure->finish();
  PLUMBLINE_TRY(report);
  // A whole exposure counts as it was asked for: measured times are a little off, and the next one begins where this one was to end.
  entry_.lit = report->end == ExposureEnd::kTimeUp ? shown.end : entry_.lit + report->lit;
  entry_.lamp += report->lit;
  record(*report, shown);
  if (state_ != PrintState::kPrinting) return false;
  // The lamp goes dark before the cover's event arrives, which may still be in the queue.
  if (report->end == ExposureEnd::kCoverOpened) watch_.request(Request::kCoverOpened);
  return report->end == ExposureEnd::kTimeUp;
}

/// Renders the mask that follows, while this one cures.
Status PrintJob::render_next(const MaskFacts& shown, const Exposure& exposure) {
  slack_.reset();
  const std::uint32_t layer = shown.is_last ? entry_.next_layer + 1 : entry_.next_layer;
  if (layer == plan_.layers) return {};
  const auto rendered = render(layer, shown.is_last ? nanoseconds() : shown.end);
  if (!rendered) return is_of_mask(rendered.error().code()) ? Status() : rendered;
  slack_ = exposure.ends_by() - machine_.clock.now();
  if (*slack_ < nanoseconds::zero()) ++report_.late_masks;
  if (shown.is_last && *slack_ > kTimeToLook) observer_.mask_made(layer, masks_.mask());
  return {};
}

/// Writes the layer to the journal before the lift, so that a power cut never cures it again in the wrong place.
Status PrintJob::layer_cured(const MaskFacts& shown) {
  const std::uint32_t layer = entry_.next_layer;
  entry_.next_layer = layer + 1;
  entry_.height = height_of(plan_, layer);
  entry_.cured_pixels += shown.pixels;
  entry_.at_hand_pixels = ready_ ? static_cast<std::uint32_t>(ready_->facts.pixels) : 0;
  entry_.lit = {};
  at_hand_lit_ = false;
  note_use();
  PLUMBLINE_TRY(write_journal());
  PLUMBLINE_TRY(watch_.wait(plan_.rest_after_exposure));
  const auto lifted = plate_.lift(layer);
  PLUMBLINE_TRY(lifted);
  // The next state finishes an interrupted lift.
  if (*lifted) PLUMBLINE_TRY(watch_.wait(plan_.wait_after_lift));
  return {};
}

void PrintJob::record(const ExposureReport& exposure, const MaskFacts& shown) {
  const Dose expected = dose_of(machine_.lamp.limits().irradiance, exposure.lit);
  report_.add({.layer = entry_.next_layer,
               .exposure = shown.exposure,
               .end = exposure.end,
               .source = exposure.source,
               .asked = exposure.asked,
               .lit = exposure.lit,
               .expected = expected,
               .dose = exposure.dose,
               .mask_hash = shown.hash,
               .next_made = slack_.has_value(),
               .slack = slack_.value_or(nanoseconds()),
               .making = ready_ ? ready_->facts.making : nanoseconds(),
               .copying = ready_ ? ready_->facts.copying : nanoseconds()});
  if (exposure.source != DoseSource::kMeasured || exposure.end != ExposureEnd::kTimeUp) return;
  if (dose_error(exposure, expected) > kDoseNoted) ++report_.doses_off;
  const auto dose = check_dose(exposure, expected, entry_.next_layer);
  if (dose.fault != FaultCode::kNone) fault(dose.fault, dose.text.view());
}

Status PrintJob::write_journal() {
  if (journal_ == nullptr) return {};
  entry_.elapsed = elapsed();
  if (const auto at = machine_.stage.position()) entry_.stands = *at;
  return journal_->append(entry_);
}

/// Writes a record that the print can do without, if the journal has room for it. Not while the journal is in doubt: if it learned where
/// the plate stands now, the next start would not ask.
Status PrintJob::write_spare() {
  return journal_ != nullptr && journal_->has_spare() && !in_doubt_ ? write_journal() : Status();
}

/// Writes to the journal where the plate rests, so that a resumed print finds it there.
Status PrintJob::note_stand() {
  const auto at = machine_.stage.position();
  return at && *at != entry_.stands ? write_spare() : Status();
}

Expected<bool> PrintJob::raise_for_pause() {
  const auto raised = plate_.raise(layer_at_hand(), pause_above(plan_, layer_at_hand()));
  if (raised && *raised) PLUMBLINE_TRY(note_stand());
  return raised;
}

Status PrintJob::raise_to_pause() {
  const auto raised = raise_for_pause();
  PLUMBLINE_TRY(raised);
  if (!apply_pending() && *raised) apply(PrintEvent::kRaised);
  return {};
}

Status PrintJob::raise_to_end() {
  if (machine_.panel.cover_open()) return wait_to_raise();
  expect(time_to_end(plan_, machine_.stage.position().value_or(ZPosition()), plan_.layers), {});
  // A print that is cancelled while it homes does not know its height. Homing goes up, too.
  const auto raised =
      machine_.stage.homed() ? plate_.raise(layer_at_hand(), {plan_.highest, plan_.fastest}) : Expected<bool>(true);
  PLUMBLINE_TRY(raised);
  if (*raised) {
    // Homing again shows whether the stage was still where its steps said.
    PLUMBLINE_TRY(plate_.home());
    if (watch_.pending() != Request::kCoverOpened || machine_.stage.homed()) apply(PrintEvent::kRaised);
  }
  apply_pending();
  return {};
}

/// A hand may be inside, so the plate stays where it is until the cover is closed.
Status PrintJob::wait_to_raise() {
  watch_.take();
  notify();
  while (machine_.panel.cover_open() && !watch_.interrupted()) {
    PLUMBLINE_TRY(watch_.wait(kLook));
    notify();
  }
  // No person can ask for this: the observer wants the print to end at once, as it is.
  if (watch_.pending() == Request::kCancel) apply(PrintEvent::kRaised);
  apply_pending();
  return {};
}

Status PrintJob::wait_for_start() {
  ready_.reset();
  if (watch_.pending() <= Request::kPause) watch_.take();  // pressed before the wait began
  const PrintState waiting = state_;
  PLUMBLINE_TRY(raise_for_pause());
  while (!apply_pending() && state_ == waiting) {
    PLUMBLINE_TRY(watch_.wait(kLook));
    notify();
  }
  return {};
}

Status PrintJob::wait_for_cover() {
  ready_.reset();
  while (!apply_pending() && state_ == PrintState::kCoverOpen) {
    PLUMBLINE_TRY(watch_.wait(kLook));
    notify();
    if (!machine_.panel.cover_open()) apply(PrintEvent::kCoverClosed);
  }
  return {};
}

Status PrintJob::cool_down() {
  ready_.reset();
  PLUMBLINE_TRY(raise_for_pause());
  const TimePoint began = machine_.clock.now();
  TimePoint well_since = began;
  while (!apply_pending() && state_ == PrintState::kCoolingDown) {
    PLUMBLINE_TRY(watch_.wait(kCoolingLook));
    notify();
    const auto found = look_at_machine(true);
    PLUMBLINE_TRY(found);
    const TimePoint now = machine_.clock.now();
    if (found->fault != FaultCode::kNone) {
      hindrance_ = *found;
      well_since = now;
    }
    if (now - well_since >= kSteady) {
      apply(PrintEvent::kCooledDown);
    } else if (now - began >= kLongWait) {
      question_.text.add("%s, for an hour: press start to wait again, or cancel", hindrance_.text.c_str());
      question_.told = PrinterCode::kWaitedLong;
      apply(PrintEvent::kPauseAsked);
    }
  }
  return {};
}

/// After any end of a print: lamp dark, panel black, part off the film, and the light that the layer has had in the journal.
/// Errors are ignored, since they were reported already or come from the loss of power.
void PrintJob::make_safe() {
  machine_.lamp.turn_off();
  ready_.reset();
  static_cast<void>(machine_.mask.blank());
  const bool can_resume = state_ == PrintState::kFault || state_ == PrintState::kSuspended;
  const bool powered = report_.fault != FaultCode::kPowerLost;
  if (can_resume && powered && entry_.lit > nanoseconds::zero()) static_cast<void>(write_spare());
  watch_.take();
  if (can_resume && machine_.stage.homed() && !machine_.panel.cover_open()) {
    // A shutdown leaves only seconds, so raise the part no further than a layer's lift.
    const std::uint32_t layer = layer_at_hand();
    const StageMove to = state_ == PrintState::kFault ? pause_above(plan_, layer) : lift_from(plan_, layer)[1];
    static_cast<void>(plate_.raise(layer, to));
    if (powered) static_cast<void>(note_stand());
  }
  note_use();
  // A lamp that is lit, or that nobody guards, is cooled for as long as the printer has power.
  const bool may_be_lit =
      machine_.lamp.lit() || report_.fault == FaultCode::kLampStuckOn || report_.fault == FaultCode::kLampKeeper;
  static_cast<void>(machine_.thermals.set_fan(Fan::kLamp, may_be_lit ? 1 : 0));
  static_cast<void>(machine_.thermals.set_fan(Fan::kChamber, 0));
}

}  // namespace

PrintReport run_print(Machine& machine, const PrintSettings& settings, MaskRenderer& masks, Journal* journal,
                      MachineRecord& record, std::span<ExposureLine> exposures, PrintObserver& observer,
                      const std::optional<JournalEntry>& from) {
  return PrintJob(machine, settings, masks, journal, record, exposures, observer).run(from);
}

}  // namespace plumbline::firmware
