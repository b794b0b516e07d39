#include "firmware/print/print_job.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

/// A tank is never emptied to the film: what is left of it does not flow under the plate.
constexpr double kUsableTank = 0.95;
/// Measured doses that are this far off are faults; the resin's own tolerance is of that order.
constexpr double kDoseFault = 0.05;
constexpr double kDoseNoted = 0.01;

double seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

LightState light_of(PanelLight light, PrintState state) {
  const auto on_if = [](bool on) { return on ? LightState::kOn : LightState::kOff; };
  const bool waits = state == PrintState::kPaused || state == PrintState::kCoverOpen || state == PrintState::kFeedMe;
  switch (light) {
    case PanelLight::kReady: return on_if(at_rest(state) && state != PrintState::kFault);
    case PanelLight::kPrinting:
      if (at_rest(state)) return LightState::kOff;
      return state == PrintState::kPrinting ? LightState::kOn : LightState::kBlinking;
    case PanelLight::kAttention: return waits ? LightState::kBlinking : on_if(state == PrintState::kFinished);
    case PanelLight::kFault: return on_if(state == PrintState::kFault);
  }
  return LightState::kOff;
}

bool calls_the_user(PrintState state) {
  return state == PrintState::kFeedMe || state == PrintState::kFinished || state == PrintState::kFault;
}

}  // namespace

PrintJob::PrintJob(Machine& machine, const PrintSettings& settings, MaskRenderer& masks, Journal* journal,
                   std::span<ExposureLine> exposures, PrintObserver& observer)
    : machine_(machine),
      settings_(settings),
      masks_(masks),
      journal_(journal),
      observer_(observer),
      lines_(exposures) {}

const PrintReport& PrintJob::run(const JournalEntry& from) {
  entry_ = from;
  before_ = from.elapsed;
  began_ = machine_.clock.now();
  report_.layers = plan_.layers;
  report_.first_layer = from.next_layer;
  report_.estimated = print_time(plan_) - (remaining_time(plan_, 0) - remaining_time(plan_, from.next_layer));
  poured_ml_ = used_ml();
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
  report_.elapsed = machine_.clock.now() - began_;
  return report_;
}

void PrintJob::apply(PrintEvent event) {
  const PrintState before = state_;
  state_ = next(state_, event);
  if (state_ == before) return;
  if (before == PrintState::kPrinting && !at_rest(state_)) report_.pauses += state_ != PrintState::kFinishing ? 1 : 0;
  // Lights that fail are no reason to end a print.
  for (std::size_t i = 0; i < kPanelLightCount; ++i) {
    const auto light = static_cast<PanelLight>(i);
    static_cast<void>(machine_.panel.set_light(light, light_of(light, state_)));
  }
  if (calls_the_user(state_)) static_cast<void>(machine_.panel.beep(std::chrono::seconds(1)));
  tell();
}

void PrintJob::fault(FaultCode code, const char* message) {
  if (report_.fault == FaultCode::kNone) {
    report_.fault = code;
    report_.fault_message.add("%s", message);
  }
  apply(code == FaultCode::kPowerLost ? PrintEvent::kShutdown : PrintEvent::kFailed);
}

void PrintJob::fail_with(const Error& error) { fault(fault_of(error.code()), error.message()); }

Status PrintJob::step() {
  if (cancel_ || shutdown_) {
    if (heed()) return {};
  }
  switch (state_) {
    case PrintState::kChecks: return run_checks();
    case PrintState::kHoming: return home();
    case PrintState::kPrinting: return print_layer();
    case PrintState::kPausing: return raise_to_pause();
    case PrintState::kPaused:
    case PrintState::kFeedMe: return wait_for_user();
    case PrintState::kCoverOpen: return wait_for_cover();
    case PrintState::kCoolingDown: return cool_down();
    case PrintState::kCancelling:
    case PrintState::kFinishing: return raise_to_end();
    case PrintState::kSlicing:
    case PrintState::kIdle:
    case PrintState::kFinished:
    case PrintState::kCancelled:
    case PrintState::kSuspended:
    case PrintState::kFault: return {};
  }
  return {};
}

Status PrintJob::home() {
  auto motion = machine_.stage.begin_homing();
  if (!motion) {
    result(Check::kStage).detail.add("%s", motion.error().message());
    conclude(Check::kStage, CheckOutcome::kFailed, fault_of(motion.error().code()));
    return tl::unexpected<Error>(motion.error());
  }
  const auto homed = finish(std::move(*motion));
  if (!homed) {
    result(Check::kStage).detail.add("%s", homed.error().message());
    conclude(Check::kStage, CheckOutcome::kFailed, fault_of(homed.error().code()));
    return tl::unexpected<Error>(homed.error());
  }
  report_.steps_lost = Distance();  // found before the print is none of its own
  if (!*homed) {
    heed();
    return {};
  }
  result(Check::kStage)
      .detail.add("end stop found at %.2f mm", machine_.stage.limits().end_stop.above_film().millimetres());
  conclude(Check::kStage, CheckOutcome::kPassed, FaultCode::kNone);
  apply(PrintEvent::kHomed);
  return {};
}

Status PrintJob::draw(std::uint32_t layer) {
  mask_.reset();
  auto buffer = machine_.mask.lend();
  PLUMBLINE_TRY(buffer);
  mask_facts_ = masks_.render(layer, buffer->image());
  mask_.emplace(std::move(*buffer));
  mask_layer_ = layer;
  return {};
}

Expected<bool> PrintJob::lower() {
  const auto down = retract_to(plan_, entry_.next_layer);
  const auto at = machine_.stage.position();
  PLUMBLINE_TRY(at);
  // From a pause or the top: fast to where the lift of a layer ends.
  const ZPosition near = std::min(down[1].target + plan_.lift + plan_.lift2, plan_.highest);
  if (*at > near) {
    const auto moved = move({near, plan_.fastest});
    if (!moved || !*moved) return moved;
  }
  for (const auto& leg : down) {
    const auto moved = move(leg);
    if (!moved || !*moved) return moved;
  }
  return true;
}

Status PrintJob::print_layer() {
  const std::uint32_t layer = entry_.next_layer;
  if (layer == plan_.layers) {
    apply(PrintEvent::kLastLayerDone);
    return {};
  }
  layer_began_ = machine_.clock.now();
  PLUMBLINE_TRY(look_after_temperatures());
  if (state_ != PrintState::kPrinting) return {};
  if (!mask_ || mask_layer_ != layer) PLUMBLINE_TRY(draw(layer));
  const double needed_ml = used_ml() - poured_ml_ + static_cast<double>(mask_facts_.pixels) * settings_.pixel_ml;
  if (needed_ml > kUsableTank * settings_.tank_ml) {
    apply(PrintEvent::kResinLow);
    return {};
  }
  const auto lowered = lower();
  PLUMBLINE_TRY(lowered);
  const auto rested = pass(*lowered ? plan_.rest_before_exposure : nanoseconds());
  PLUMBLINE_TRY(rested);
  if (!*rested || pause_) {
    heed();
    return {};
  }
  PLUMBLINE_TRY(machine_.mask.present(std::move(*mask_)));
  mask_.reset();
  shown_facts_ = mask_facts_;
  const auto cured = expose();
  PLUMBLINE_TRY(cured);
  PLUMBLINE_TRY(machine_.mask.blank());
  if (!*cured) {
    heed();
    return {};
  }
  entry_.next_layer = layer + 1;
  entry_.height = height_of(plan_, layer);
  entry_.cured_pixels += shown_facts_.pixels;
  entry_.lit = {};
  PLUMBLINE_TRY(write_journal());

  const auto rested_after = pass(plan_.rest_after_exposure);
  PLUMBLINE_TRY(rested_after);
  for (const auto& leg : lift_from(plan_, layer)) {
    const auto moved = move(leg);
    PLUMBLINE_TRY(moved);
    if (!*moved) break;  // how the part comes up is then the next state's
  }
  PLUMBLINE_TRY(pass(asked_to_stop() ? nanoseconds() : plan_.wait_after_lift));
  const nanoseconds took = machine_.clock.now() - layer_began_;
  if (took > report_.slowest) {
    report_.slowest = took;
    report_.slowest_layer = layer;
  }
  tell();
  if (entry_.next_layer == plan_.layers && !asked_to_stop()) {
    apply(PrintEvent::kLastLayerDone);
  } else {
    heed();
  }
  return {};
}

/// @returns false: stopped before the layer had all its light
Expected<bool> PrintJob::expose() {
  const std::uint32_t layer = entry_.next_layer;
  const nanoseconds cure = exposure_of(plan_, layer) - entry_.lit;
  if (cure <= nanoseconds::zero()) return true;
  auto exposure = machine_.lamp.begin_exposure(cure);
  if (!exposure && exposure.error().code() == ErrorCode::kCoverOpen) {
    cover_opened_ = true;
    return false;
  }
  PLUMBLINE_TRY(exposure);
  slack_.reset();
  const bool has_next = layer + 1 < plan_.layers;
  if (has_next) {
    PLUMBLINE_TRY(draw(layer + 1));
    slack_ = exposure->ends_by() - machine_.clock.now();
    if (*slack_ < nanoseconds::zero()) ++report_.late_masks;
  }
  const auto over =
      await(*exposure, machine_.events, machine_.clock, [this](const Event& event) { return hear(event); });
  PLUMBLINE_TRY(over);
  const auto report = exposure->finish();
  PLUMBLINE_TRY(report);
  entry_.lit += report->lit;
  note(*report);
  if (state_ != PrintState::kPrinting) return false;
  // The event of the cover may still be in the queue; the light is out already.
  if (report->end == ExposureEnd::kCoverOpened) cover_opened_ = true;
  return report->end == ExposureEnd::kTimeUp;
}

void PrintJob::note(const ExposureReport& exposure) {
  const Dose expected = dose_of(machine_.lamp.limits().irradiance, exposure.lit);
  if (report_.exposures.size() < lines_.size()) {
    ExposureLine& line = lines_[report_.exposures.size()];
    line = {.layer = entry_.next_layer,
            .end = exposure.end,
            .source = exposure.source,
            .asked = exposure.asked,
            .lit = exposure.lit,
            .expected = expected,
            .dose = exposure.dose,
            .mask_hash = shown_facts_.hash,
            .slack = slack_.value_or(nanoseconds()),
            .next_made = slack_.has_value(),
            .making = slack_ ? mask_facts_.making : nanoseconds(),
            .copying = slack_ ? mask_facts_.copying : nanoseconds()};
    report_.exposures = lines_.first(report_.exposures.size() + 1);
  } else {
    ++report_.exposures_untold;
  }
  if (exposure.source == DoseSource::kComputed || exposure.end != ExposureEnd::kTimeUp) return;
  const double off = std::abs(exposure.dose / expected - 1);
  if (off > kDoseNoted) ++report_.doses_off;
  if (off > kDoseFault) {
    FixedText<160> text;
    text.add("layer %u got %.3g mJ/cm2 in %.2f s, it should have been %.3g mJ/cm2", entry_.next_layer,
             exposure.dose.value(), seconds(exposure.lit), expected.value());
    fault(FaultCode::kDoseOff, text.c_str());
  }
}

Status PrintJob::write_journal() {
  if (journal_ == nullptr) return {};
  entry_.elapsed = before_ + (machine_.clock.now() - began_);
  return journal_->append(entry_);
}

/// Peels what may stick to the film, slowly, then goes up. @returns false: something came up, and the stage stands
Expected<bool> PrintJob::raise(const StageMove& to) {
  const auto at = machine_.stage.position();
  PLUMBLINE_TRY(at);
  if (*at >= to.target) return !asked_to_stop();
  const std::uint32_t layer = std::min(entry_.next_layer, plan_.layers - 1);
  if (*at < height_of(plan_, layer) + plan_.lift) {
    const auto peeled = move({std::min(*at + plan_.lift, to.target), plan_.lift_speed});
    if (!peeled || !*peeled) return peeled;
  }
  return move(to);
}

Status PrintJob::raise_to_pause() {
  const auto raised = raise(pause_above(plan_, std::min(entry_.next_layer, plan_.layers - 1)));
  PLUMBLINE_TRY(raised);
  if (!heed() && *raised) apply(PrintEvent::kRaised);
  return {};
}

Status PrintJob::raise_to_end() {
  const auto raised = raise({plan_.highest, plan_.fastest});
  PLUMBLINE_TRY(raised);
  if (*raised) {
    // Up there the end stop tells whether the stage still was where its steps said.
    auto motion = machine_.stage.begin_homing();
    PLUMBLINE_TRY(motion);
    const auto homed = finish(std::move(*motion));
    PLUMBLINE_TRY(homed);
    apply(PrintEvent::kRaised);
  }
  heed();
  return {};
}

Status PrintJob::wait_for_user() {
  mask_.reset();
  resume_ = false;
  pause_ = false;
  const PrintState waiting = state_;
  const auto raised = raise(pause_above(plan_, std::min(entry_.next_layer, plan_.layers - 1)));
  PLUMBLINE_TRY(raised);
  while (!heed() && state_ == waiting) {
    PLUMBLINE_TRY(pass(std::chrono::milliseconds(200)));
    tell();
    if (!resume_ || asked_to_stop()) continue;
    resume_ = false;
    if (machine_.panel.cover_open()) {
      static_cast<void>(machine_.panel.beep(std::chrono::milliseconds(200)));
      continue;
    }
    if (state_ == PrintState::kFeedMe) poured_ml_ = used_ml();
    apply(PrintEvent::kResumeAsked);
  }
  return {};
}

Status PrintJob::wait_for_cover() {
  mask_.reset();
  while (!heed() && state_ == PrintState::kCoverOpen) {
    PLUMBLINE_TRY(pass(std::chrono::milliseconds(200)));
    tell();
    if (!machine_.panel.cover_open()) apply(PrintEvent::kCoverClosed);
  }
  return {};
}

Status PrintJob::cool_down() {
  mask_.reset();
  const auto raised = raise(pause_above(plan_, std::min(entry_.next_layer, plan_.layers - 1)));
  PLUMBLINE_TRY(raised);
  while (!heed() && state_ == PrintState::kCoolingDown) {
    PLUMBLINE_TRY(pass(std::chrono::seconds(2)));
    tell();
    const auto lamp = machine_.thermals.temperature(TemperatureSite::kLamp);
    PLUMBLINE_TRY(lamp);
    if (*lamp < settings_.lamp_resume) apply(PrintEvent::kCooledDown);
  }
  return {};
}

/// However the print ended: dark, black, the part off the film, the light that a layer has had already written down. What fails
/// here has been told, or is the loss of power.
void PrintJob::make_safe() {
  machine_.lamp.turn_off();
  mask_.reset();
  static_cast<void>(machine_.mask.blank());
  const bool goes_on = state_ == PrintState::kFault || state_ == PrintState::kSuspended;
  const bool powered = report_.fault != FaultCode::kPowerLost;
  if (goes_on && powered && entry_.lit > nanoseconds::zero()) static_cast<void>(write_journal());
  shutdown_ = cancel_ = cover_opened_ = false;
  if (goes_on && machine_.stage.homed() && !machine_.panel.cover_open()) {
    const std::uint32_t layer = std::min(entry_.next_layer, plan_.layers - 1);
    // Whoever shuts down has seconds.
    static_cast<void>(raise(state_ == PrintState::kFault ? pause_above(plan_, layer) : lift_from(plan_, layer)[1]));
  }
  static_cast<void>(machine_.thermals.set_fan(Fan::kLamp, 0));
  static_cast<void>(machine_.thermals.set_fan(Fan::kChamber, 0));
}

}  // namespace plumbline
