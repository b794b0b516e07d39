#pragma once
/// What a print does, or why it does not go on, in a line for the service manager.

#include "firmware/io/fixed_text.hpp"
#include "firmware/print/print_job.hpp"

namespace plumbline {

/// "layer 12 of 300, 0:45:10 left", "paused at layer 12 of 300: the cover is open", ... Layers count from 1.
FixedText<200> service_status(const PrintStatus& status);

/// The same when it is over: "finished", or the fault and what to do.
FixedText<200> service_status(const PrintReport& report);

}  // namespace plumbline
