#pragma once
/// The keeper: a separate process that holds the lamp's line and turns it off in time.

#include <sys/types.h>

#include "hal/linux/keeper/cover_line.hpp"
#include "hal/linux/keeper/lamp_line.hpp"
#include "hal/linux/keeper/light_budget.hpp"
#include "hal/linux/keeper/watchdog.hpp"

namespace plumbline::inline hal::inline linux_board {

/// What the keeper holds and whom it serves.
struct KeeperDuty {
  LampLine& line;
  CoverLine* cover = nullptr;    ///< null: the printer has no cover switch
  Watchdog* watchdog = nullptr;  ///< null: the board has none
  int socket = -1;               ///< SOCK_SEQPACKET, connected to the firmware
  int watch_socket = -1;         ///< the same, for pings
  pid_t firmware = 0;            ///< the process that started the keeper
  LightLimits limits;
  std::chrono::nanoseconds lit_before{};  ///< of a keeper before this one, in the last minute
};

/// Serves the firmware until its socket or process ends, until it stops answering, or until SIGTERM, SIGINT or SIGHUP. The line is off
/// when this returns.
///
/// - the timer that turns the line off is armed before the line goes on
/// - the line goes off at the first of: the deadline, an open cover, a request, the end or the silence of the firmware
/// - a firmware that is silent is killed once the line is off
/// - the watchdog is fed while the firmware is well, and stopped only if the firmware says that it ends
/// @returns exit status: 0, or 1 if timer, signals or process could not be watched; then nothing was lit
int keep_lamp(const KeeperDuty& duty);

}  // namespace plumbline::inline hal::inline linux_board
