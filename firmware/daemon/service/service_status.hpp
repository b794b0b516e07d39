#pragma once

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/status/print_report.hpp"

namespace plumbline::firmware {

/// How a print ended, in a line for the service manager: "finished", or the fault and what to do.
FixedText<200> service_status(const PrintReport& report);

}  // namespace plumbline::firmware
