#include "firmware/print/status/state_lights.hpp"

#include <chrono>

namespace plumbline {
namespace {

LightState on_if(bool on) { return on ? LightState::kOn : LightState::kOff; }

}  // namespace

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

}  // namespace plumbline
