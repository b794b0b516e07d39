#pragma once
/// The keeper: a process of its own that holds the lamp's line and knows one thing, when to turn it off.

#include <cstdint>

#include "hal/linux/lamp/cover_line.hpp"
#include "hal/linux/lamp/lamp_line.hpp"

namespace plumbline {

/// Serves the firmware until its socket or its process ends, or the keeper is told to end (SIGTERM, SIGINT, SIGHUP). The line
/// is off when this returns.
///
/// - the timer that turns it off is armed before the line goes on
/// - what comes first turns it off: the deadline, the cover, a word of the firmware, the end of its socket, the end of its
///   process
/// @param cover   null: the printer has no switch there
/// @param socket  SOCK_SEQPACKET, connected to the firmware
/// @param firmware  its process
/// @returns exit status: 0, or 1 where timer, signals or socket could not be set up and nothing was lit
int keep_lamp(LampLine& line, CoverLine* cover, int socket, int firmware);

}  // namespace plumbline
