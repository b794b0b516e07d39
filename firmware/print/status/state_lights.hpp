#pragma once

#include "firmware/print/status/print_state.hpp"
#include "hal/front_panel.hpp"

namespace plumbline {

/// Sets the front panel's lights for a state, and beeps in those that need the user. A panel that fails is ignored: it is no
/// reason to end a print.
void show_on_panel(FrontPanel& panel, PrintState state);

}  // namespace plumbline
