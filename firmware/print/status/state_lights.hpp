#pragma once

#include "firmware/print/status/print_state.hpp"
#include "hal/front_panel.hpp"

namespace plumbline {

/// What a light of the front panel does in a state.
LightState light_for(PanelLight light, PrintState state);
/// Whether the buzzer calls for somebody when a state begins.
bool calls_the_user(PrintState state);

/// Sets the front panel's lights for a state, and beeps in those that need the user. A panel that fails is ignored: it is no
/// reason to end a print.
void show_on_panel(FrontPanel& panel, PrintState state);

}  // namespace plumbline
