#pragma once
/// The state machine of a print: a pure, total function. PrintJob holds the state of a print, the daemon's record the printer's. Each is
/// assigned in one place; while PrintJob prints, the record follows it.

#include <array>
#include <cstdint>
#include <string_view>

#include "hal/front_panel.hpp"

namespace plumbline::firmware {

enum class PrintState : std::uint8_t {
  kIdle,         ///< waits for a job
  kOffered,      ///< a job is at hand: waits until somebody presses start
  kInterrupted,  ///< an interrupted print can go on: waits for start or cancel
  kPlateInUse,   ///< waits until somebody confirms that the plate is empty
  kSlicing,      ///< reads the scan and builds the R-Rep
  kChecks,       ///< checks printer and job
  kHoming,       ///< the stage finds its end stop
  kPrinting,     ///< layer after layer
  kPausing,      ///< raises the part; the lamp is dark
  kPaused,       ///< holds the part up until the user presses start
  kCoverOpen,    ///< the lamp is dark until the cover is closed
  kCoolingDown,  ///< waits, with the lamp dark, for temperatures and fans; goes on by itself
  kFeedMe,       ///< waits for resin, and for start
  kCancelling,   ///< raises what has been printed
  kFinishing,    ///< raises the finished part
  kFinished,     ///< the part is ready
  kCancelled,    ///< by the user; what has been printed is on the plate
  kSuspended,    ///< power lost or system shut down: the journal knows where to resume
  kFault,        ///< something failed: the fault's code says what, and what the user does next
};
inline constexpr std::size_t kPrintStateCount = 19;

enum class PrintEvent : std::uint8_t {
  kJobOffered,     ///< a stick with a job is in the port
  kResumeOffered,  ///< an interrupted print is stored
  kPlateTaken,     ///< a print has begun since somebody last confirmed that the plate is empty
  kPlateEmpty,     ///< somebody confirms that the plate is empty
  kJobTaken,       ///< somebody wants the scan to be printed
  kJobResumed,     ///< a job is ready to print: sliced, or loaded with its journal
  kSliced,         ///< the R-Rep is ready
  kChecksPassed,   ///<
  kHomed,          ///< the stage knows its height
  kPartInDoubt,    ///< the same, but the user must measure the part first
  kPauseAsked,     ///< by the user
  kRaised,         ///< the part is up
  kResumeAsked,    ///< by the user
  kCoverOpened,    ///<
  kCoverClosed,    ///<
  kTooHot,         ///< the lamp
  kCooledDown,     ///<
  kResinLow,       ///< the tank has less than the next layer needs
  kLastLayerDone,  ///<
  kCancelAsked,    ///< by the user
  kShutdown,       ///< power lost, or the system shuts down
  kFailed,         ///< a fault
  kAcknowledged,   ///< the user has seen the result
};
inline constexpr std::size_t kPrintEventCount = 23;

/// "idle", "cooling down", "feed me", ...
std::string_view to_string(PrintState state);
/// "pause asked", ...
std::string_view to_string(PrintEvent event);

/// No job is running: nothing lights or moves.
constexpr bool at_rest(PrintState state) {
  switch (state) {
    case PrintState::kIdle:
    case PrintState::kOffered:
    case PrintState::kInterrupted:
    case PrintState::kPlateInUse:
    case PrintState::kFinished:
    case PrintState::kCancelled:
    case PrintState::kSuspended:
    case PrintState::kFault: return true;
    case PrintState::kSlicing:
    case PrintState::kChecks:
    case PrintState::kHoming:
    case PrintState::kPrinting:
    case PrintState::kPausing:
    case PrintState::kPaused:
    case PrintState::kCoverOpen:
    case PrintState::kCoolingDown:
    case PrintState::kFeedMe:
    case PrintState::kCancelling:
    case PrintState::kFinishing: return false;
  }
  return true;
}

/// A pause that lasts until the user presses start.
constexpr bool waits_for_start(PrintState state) {
  return state == PrintState::kPaused || state == PrintState::kFeedMe;
}

/// The part is raised for good.
constexpr bool is_raise_to_end(PrintState state) {
  return state == PrintState::kCancelling || state == PrintState::kFinishing;
}

/// A pause of any kind, which the print can leave to go on.
constexpr bool is_pause(PrintState state) {
  return waits_for_start(state) || state == PrintState::kPausing || state == PrintState::kCoverOpen ||
         state == PrintState::kCoolingDown;
}

/// Transitions that all running states share.
constexpr PrintState next_running(PrintState state, PrintEvent event) {
  switch (event) {
    case PrintEvent::kCoverOpened: return PrintState::kCoverOpen;
    case PrintEvent::kCancelAsked: return PrintState::kCancelling;
    case PrintEvent::kShutdown: return PrintState::kSuspended;
    case PrintEvent::kFailed: return PrintState::kFault;
    case PrintEvent::kJobOffered:
    case PrintEvent::kResumeOffered:
    case PrintEvent::kPlateTaken:
    case PrintEvent::kPlateEmpty:
    case PrintEvent::kJobTaken:
    case PrintEvent::kJobResumed:
    case PrintEvent::kSliced:
    case PrintEvent::kChecksPassed:
    case PrintEvent::kHomed:
    case PrintEvent::kPartInDoubt:
    case PrintEvent::kPauseAsked:
    case PrintEvent::kRaised:
    case PrintEvent::kResumeAsked:
    case PrintEvent::kCoverClosed:
    case PrintEvent::kTooHot:
    case PrintEvent::kCooledDown:
    case PrintEvent::kResinLow:
    case PrintEvent::kLastLayerDone:
    case PrintEvent::kAcknowledged: return state;
  }
  return PrintState::kFault;
}

/// The state after `event`. Total: events that a state does not know leave it unchanged.
constexpr PrintState next(PrintState state, PrintEvent event) {
  switch (state) {
    case PrintState::kIdle:
      if (event == PrintEvent::kJobOffered) return PrintState::kOffered;
      if (event == PrintEvent::kResumeOffered) return PrintState::kInterrupted;
      if (event == PrintEvent::kPlateTaken) return PrintState::kPlateInUse;
      if (event == PrintEvent::kJobResumed) return PrintState::kChecks;  // where PrintJob begins
      if (event == PrintEvent::kFailed) return PrintState::kFault;
      return state;
    case PrintState::kOffered:
      if (event == PrintEvent::kJobTaken) return PrintState::kSlicing;
      if (event == PrintEvent::kCancelAsked) return PrintState::kIdle;
      if (event == PrintEvent::kFailed) return PrintState::kFault;
      return state;
    case PrintState::kInterrupted:
      if (event == PrintEvent::kJobResumed) return PrintState::kChecks;
      if (event == PrintEvent::kCancelAsked) return PrintState::kPlateInUse;  // its part is still there
      if (event == PrintEvent::kFailed) return PrintState::kFault;
      return state;
    case PrintState::kPlateInUse:
      // Also after a fault: only a person's word leads out of this state.
      if (event == PrintEvent::kPlateEmpty) return PrintState::kIdle;
      return state;
    case PrintState::kSlicing:
      if (event == PrintEvent::kSliced) return PrintState::kChecks;
      if (event == PrintEvent::kJobOffered) return PrintState::kOffered;     // again, with what was found in its layers
      if (event == PrintEvent::kCancelAsked) return PrintState::kCancelled;  // nothing has moved, so nothing is raised
      if (event == PrintEvent::kShutdown) return PrintState::kSuspended;
      if (event == PrintEvent::kFailed) return PrintState::kFault;
      return state;
    case PrintState::kChecks:
      if (event == PrintEvent::kChecksPassed) return PrintState::kHoming;
      if (event == PrintEvent::kCancelAsked) return PrintState::kCancelled;
      if (event == PrintEvent::kShutdown) return PrintState::kSuspended;
      if (event == PrintEvent::kFailed) return PrintState::kFault;
      return state;
    case PrintState::kHoming:
      if (event == PrintEvent::kHomed) return PrintState::kPrinting;
      if (event == PrintEvent::kPartInDoubt) return PrintState::kPaused;
      return next_running(state, event);
    case PrintState::kPrinting:
      if (event == PrintEvent::kPauseAsked) return PrintState::kPausing;
      if (event == PrintEvent::kTooHot) return PrintState::kCoolingDown;
      if (event == PrintEvent::kResinLow) return PrintState::kFeedMe;
      if (event == PrintEvent::kLastLayerDone) return PrintState::kFinishing;
      return next_running(state, event);
    case PrintState::kPausing:
      if (event == PrintEvent::kRaised) return PrintState::kPaused;
      return next_running(state, event);
    case PrintState::kPaused:
      if (event == PrintEvent::kResumeAsked) return PrintState::kPrinting;
      return next_running(state, event);
    case PrintState::kCoverOpen:
      // Paused, not printing: whoever had a hand inside presses start when it is out.
      if (event == PrintEvent::kCoverClosed) return PrintState::kPaused;
      return next_running(state, event);
    case PrintState::kCoolingDown:
      if (event == PrintEvent::kCooledDown) return PrintState::kPrinting;
      if (event == PrintEvent::kPauseAsked) return PrintState::kPaused;
      return next_running(state, event);
    case PrintState::kFeedMe:
      if (event == PrintEvent::kCoverOpened) return state;  // resin is poured in with the cover open
      if (event == PrintEvent::kResumeAsked) return PrintState::kPrinting;
      return next_running(state, event);
    case PrintState::kCancelling:
      if (event == PrintEvent::kRaised) return PrintState::kCancelled;
      if (event == PrintEvent::kShutdown) return PrintState::kSuspended;
      if (event == PrintEvent::kFailed) return PrintState::kFault;
      return state;
    case PrintState::kFinishing:
      if (event == PrintEvent::kRaised) return PrintState::kFinished;
      if (event == PrintEvent::kShutdown) return PrintState::kSuspended;
      if (event == PrintEvent::kFailed) return PrintState::kFault;
      return state;
    case PrintState::kFinished:
    case PrintState::kCancelled:
    case PrintState::kSuspended:
    case PrintState::kFault:
      if (event == PrintEvent::kAcknowledged) return PrintState::kIdle;
      return state;
  }
  return PrintState::kFault;
}

/// What a light of the front panel does in a state.
LightState light_for(PanelLight light, PrintState state);
/// Whether the buzzer calls for somebody when a state begins.
bool calls_the_user(PrintState state);

/// Sets the front panel's lights for a state, and beeps in those that need the user. A panel that fails is ignored: it is no
/// reason to end a print.
void show_on_panel(FrontPanel& panel, PrintState state);

}  // namespace plumbline::firmware
