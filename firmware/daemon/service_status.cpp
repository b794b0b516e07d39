#include "firmware/daemon/service_status.hpp"

#include <algorithm>

#include "firmware/print/print_lines.hpp"

namespace plumbline {
namespace {

/// Why a print waits, and what makes it go on; null in a state that does not wait.
const char* reason_to_wait(PrintState state) {
  switch (state) {
    case PrintState::kPausing:
    case PrintState::kPaused: return "start goes on";
    case PrintState::kCoverOpen: return "the cover is open";
    case PrintState::kCoolingDown: return "the lamp is too hot, the print goes on when it is cool";
    case PrintState::kFeedMe: return "the tank is nearly empty: pour resin in, then start goes on";
    case PrintState::kIdle:
    case PrintState::kSlicing:
    case PrintState::kChecks:
    case PrintState::kHoming:
    case PrintState::kPrinting:
    case PrintState::kCancelling:
    case PrintState::kFinishing:
    case PrintState::kFinished:
    case PrintState::kCancelled:
    case PrintState::kSuspended:
    case PrintState::kFault: return nullptr;
  }
  return nullptr;
}

}  // namespace

FixedText<200> service_status(const PrintStatus& status) {
  FixedText<200> text;
  const std::uint32_t layer = std::min(status.layer + 1, status.layers);
  if (const char* const reason = reason_to_wait(status.state)) {
    text.add("paused at layer %u of %u: %s", layer, status.layers, reason);
  } else if (status.state == PrintState::kPrinting) {
    text.add("layer %u of %u, %s left", layer, status.layers, clock_text(status.remaining).c_str());
  } else {
    const auto state = to_string(status.state);
    text.add("%.*s", static_cast<int>(state.size()), state.data());
  }
  return text;
}

FixedText<200> service_status(const PrintReport& report) {
  FixedText<200> text;
  if (report.fault == FaultCode::kNone) {
    const auto state = to_string(report.state);
    text.add("%.*s", static_cast<int>(state.size()), state.data());
    return text;
  }
  const FaultInfo& fault = info(report.fault);
  text.add("PL-%u, %.*s. %.*s", static_cast<unsigned>(report.fault), static_cast<int>(fault.title.size()),
           fault.title.data(), static_cast<int>(fault.next.size()), fault.next.data());
  return text;
}

}  // namespace plumbline
