#pragma once
/// What happens to the machine, in order. Asking for the next event is how the firmware waits.

#include <cstdint>
#include <optional>
#include <string_view>

#include "hal/clock.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

enum class EventKind : std::uint8_t {
  kStartPressed,       ///< button: print, or resume where paused
  kPausePressed,       ///< button
  kCancelPressed,      ///< button
  kCoverOpened,        ///< the lamp is dark already: see UvLamp
  kCoverClosed,        ///<
  kStickArrived,       ///< and can be mounted
  kStickDeparted,      ///< pulled, or no longer answering
  kExposureEnded,      ///< the lamp's line is off again, for whatever reason: Exposure::finish() tells
  kMotionEnded,        ///< the stage stands, for whatever reason: Motion::finish() tells
  kShutdownRequested,  ///< by the system: finish what is in hand within seconds
};

/// "start pressed", "cover opened", ...
std::string_view to_string(EventKind kind);

struct Event {
  TimePoint at;  ///< when it happened, not when it was asked for
  EventKind kind = EventKind::kShutdownRequested;
};

/// One queue for all devices. Nothing is lost and nothing comes twice; bouncing contacts have been quieted.
class Events {
 public:
  Events() = default;
  Events(const Events&) = delete;
  Events& operator=(const Events&) = delete;
  virtual ~Events() = default;

  /// The oldest event that has not been delivered, waiting for it until `deadline` at most. With a deadline that has passed it
  /// polls.
  /// @returns nothing when the deadline passes without an event
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<std::optional<Event>> next_event(TimePoint deadline) { return do_next_event(deadline); }

 private:
  virtual Expected<std::optional<Event>> do_next_event(TimePoint deadline) = 0;
};

}  // namespace plumbline
