#include "hal/events.hpp"
#include "hal/thermals.hpp"

namespace plumbline::inline hal {

std::string_view to_string(EventKind kind) {
  switch (kind) {
    case EventKind::kStartPressed: return "start pressed";
    case EventKind::kPausePressed: return "pause pressed";
    case EventKind::kCancelPressed: return "cancel pressed";
    case EventKind::kCoverOpened: return "cover opened";
    case EventKind::kCoverClosed: return "cover closed";
    case EventKind::kStickArrived: return "stick arrived";
    case EventKind::kStickDeparted: return "stick departed";
    case EventKind::kExposureEnded: return "exposure ended";
    case EventKind::kMotionEnded: return "motion ended";
    case EventKind::kShutdownRequested: return "shutdown requested";
  }
  return "unknown event";
}

std::string_view to_string(TemperatureSite site) {
  switch (site) {
    case TemperatureSite::kLamp: return "lamp";
    case TemperatureSite::kResin: return "resin";
    case TemperatureSite::kBoard: return "board";
  }
  return "unknown site";
}

std::string_view to_string(Fan fan) {
  switch (fan) {
    case Fan::kLamp: return "lamp";
    case Fan::kChamber: return "chamber";
  }
  return "unknown fan";
}

}  // namespace plumbline::inline hal
