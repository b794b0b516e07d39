#pragma once
/// Values that every back end derives from the machine's part of a board file.

#include "firmware/settings/board_file.hpp"
#include "hal/clock.hpp"
#include "hal/uv_lamp.hpp"
#include "hal/z_stage.hpp"

namespace plumbline::firmware {

/// @param ms  at most some hours: a double holds these to the nanosecond
nanoseconds nanoseconds_of_ms(double ms);

/// Travel from the film (0) to just below the end stop, and the fastest motion.
ZStage::Limits travel_limits(const MachineFile& machine);

UvLamp::Limits lamp_limits(const MachineFile& machine);

}  // namespace plumbline::firmware
