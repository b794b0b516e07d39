#include "firmware/print/status/print_state.hpp"

#include <chrono>

namespace plumbline::firmware {
namespace {

LightState on_if(bool on) { return on ? LightState::kOn : LightState::kOff; }

}  // namespace

std::string_view to_string(PrintState state) {
  switch (state) {
    case PrintState::kIdle: return "idle";
    case PrintState::kOffered: return "offered";
    case PrintState::kInterrupted: return "interrupted";
    case PrintState::kPlateInUse: return "plate in use";
    case PrintState::kSlicing: return "slicing";
    case PrintState::kChecks: return "checks";
    case PrintState::kHoming: return "homing";
    case PrintState::kPrinting: return "printing";
    case PrintState::kPausing: return "pausing";
    case PrintState::kPaused: return "paused";
    case PrintState::kCoverOpen: return "cover open";
    case PrintState::kCoolingDown: return "cooling down";
    case PrintState::kFeedMe: return "feed me";
    case PrintState::kCancelling: return "cancelling";
    case PrintState::kFinishing: return "finishing";
    case PrintState::kFinished: return "finished";
    case PrintState::kCancelled: return "cancelled";
    case PrintState::kSuspended: return "suspended";
    case PrintState::kFault: return "fault";
  }
  return "unknown state";
}

std::string_view to_string(PrintEvent event) {
  switch (event) {
    case PrintEvent::kJobOffered: return "job offered";
    case PrintEvent::kResumeOffered: return "resume offered";
    case PrintEvent::kPlateTaken: return "plate taken";
    case PrintEvent::kPlateEmpty: return "plate empty";
    case PrintEvent::kJobTaken: return "job taken";
    case PrintEvent::kJobResumed: return "job resumed";
    case PrintEvent::kSliced: return "sliced";
    case PrintEvent::kChecksPassed: return "checks passed";
    case PrintEvent::kHomed: return "homed";
    case PrintEvent::kPartInDoubt: return "part in doubt";
    case PrintEvent::kPauseAsked: return "pause asked";
    case PrintEvent::kRaised: return "raised";
    case PrintEvent::kResumeAsked: return "resume asked";
    case PrintEvent::kCoverOpened: return "cover opened";
    case PrintEvent::kCoverClosed: return "cover closed";
    case PrintEvent::kTooHot: return "too hot";
    case PrintEvent::kCooledDown: return "cooled down";
    case PrintEvent::kResinLow: return "resin low";
    case PrintEvent::kLastLayerDone: return "last layer done";
    case PrintEvent::kCancelAsked: return "cancel asked";
    case PrintEvent::kShutdown: return "shutdown";
    case PrintEvent::kFailed: return "failed";
    case PrintEvent::kAcknowledged: return "acknowledged";
  }
  return "unknown event";
}

LightState light_for(PanelLight light, PrintState state) {
  const bool waits = waits_for_start(state) || state == PrintState::kCoverOpen || state == PrintState::kOffered ||
                     state == PrintState::kInterrupted;
  const bool part_is_there = state == PrintState::kFinished || state == PrintState::kPlateInUse;
  switch (light) {
    case PanelLight::kReady: return on_if(state == PrintState::kIdle || state == PrintState::kOffered);
    case PanelLight::kPrinting:
      if (at_rest(state)) return LightState::kOff;
      return state == PrintState::kPrinting ? LightState::kOn : LightState::kBlinking;
    case PanelLight::kAttention: return waits ? LightState::kBlinking : on_if(part_is_there);
    case PanelLight::kFault: return on_if(state == PrintState::kFault);
  }
  return LightState::kOff;
}

bool calls_the_user(PrintState state) {
  return state == PrintState::kFeedMe || state == PrintState::kFinished || state == PrintState::kFault;
}

void show_on_panel(FrontPanel& panel, PrintState state) {
  for (std::size_t i = 0; i < kPanelLightCount; ++i) {
    const auto light = static_cast<PanelLight>(i);
    static_cast<void>(panel.set_light(light, light_for(light, state)));
  }
  if (calls_the_user(state)) static_cast<void>(panel.beep(std::chrono::seconds(1)));
}
}  // namespace plumbline::firmware
