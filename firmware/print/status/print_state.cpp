#include "firmware/print/status/print_state.hpp"

namespace plumbline {

std::string_view to_string(PrintState state) {
  switch (state) {
    case PrintState::kIdle: return "idle";
    case PrintState::kOffered: return "offered";
    case PrintState::kInterrupted: return "interrupted";
    case PrintState::kPlateInUse: return "plate in use";
    case PrintState::kSlicing: return "slicing";
    case PrintState::kChecks: return "checks";
    case PrintState::kHoming: return "homing";
    case PrintState::kPrinting: return "printing";
    case PrintState::kPausing: return "pausing";
    case PrintState::kPaused: return "paused";
    case PrintState::kCoverOpen: return "cover open";
    case PrintState::kCoolingDown: return "cooling down";
    case PrintState::kFeedMe: return "feed me";
    case PrintState::kCancelling: return "cancelling";
    case PrintState::kFinishing: return "finishing";
    case PrintState::kFinished: return "finished";
    case PrintState::kCancelled: return "cancelled";
    case PrintState::kSuspended: return "suspended";
    case PrintState::kFault: return "fault";
  }
  return "unknown state";
}

std::string_view to_string(PrintEvent event) {
  switch (event) {
    case PrintEvent::kJobOffered: return "job offered";
    case PrintEvent::kResumeOffered: return "resume offered";
    case PrintEvent::kPlateTaken: return "plate taken";
    case PrintEvent::kPlateEmpty: return "plate empty";
    case PrintEvent::kJobTaken: return "job taken";
    case PrintEvent::kJobResumed: return "job resumed";
    case PrintEvent::kSliced: return "sliced";
    case PrintEvent::kChecksPassed: return "checks passed";
    case PrintEvent::kHomed: return "homed";
    case PrintEvent::kPartInDoubt: return "part in doubt";
    case PrintEvent::kPauseAsked: return "pause asked";
    case PrintEvent::kRaised: return "raised";
    case PrintEvent::kResumeAsked: return "resume asked";
    case PrintEvent::kCoverOpened: return "cover opened";
    case PrintEvent::kCoverClosed: return "cover closed";
    case PrintEvent::kTooHot: return "too hot";
    case PrintEvent::kCooledDown: return "cooled down";
    case PrintEvent::kResinLow: return "resin low";
    case PrintEvent::kLastLayerDone: return "last layer done";
    case PrintEvent::kCancelAsked: return "cancel asked";
    case PrintEvent::kShutdown: return "shutdown";
    case PrintEvent::kFailed: return "failed";
    case PrintEvent::kAcknowledged: return "acknowledged";
  }
  return "unknown event";
}

}  // namespace plumbline
