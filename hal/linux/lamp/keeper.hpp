#pragma once
/// The keeper: a separate process that holds the lamp's line and turns it off in time.

#include <cstdint>

#include "hal/linux/lamp/cover_line.hpp"
#include "hal/linux/lamp/lamp_line.hpp"

namespace plumbline {

/// Serves the firmware until its socket or process ends, or until SIGTERM, SIGINT or SIGHUP. The line is off when this returns.
///
/// - the timer that turns the line off is armed before the line goes on
/// - the line goes off at the first of: the deadline, an open cover, a request, the end of the firmware's socket or process
/// @param cover     null: the printer has no cover switch
/// @param socket    SOCK_SEQPACKET, connected to the firmware
/// @param firmware  process ID
/// @returns exit status: 0, or 1 if timer, signals or process could not be watched; then nothing was lit
int keep_lamp(LampLine& line, CoverLine* cover, int socket, int firmware);

}  // namespace plumbline
