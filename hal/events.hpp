#pragma once
/// What happens to the machine, in order. The firmware waits by asking for the next event.

#include <cstdint>
#include <optional>
#include <string_view>

#include "hal/clock.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

enum class EventKind : std::uint8_t {
  kStartPressed,       ///< button: print, or resume a paused print
  kPausePressed,       ///< button
  kCancelPressed,      ///< button
  kCoverOpened,        ///< the lamp is already dark: see UvLamp
  kCoverClosed,        ///<
  kStickArrived,       ///< the stick can be mounted
  kStickDeparted,      ///< the stick was pulled or stopped answering
  kExposureEnded,      ///< the lamp's line is off again; Exposure::finish() says why
  kMotionEnded,        ///< the stage has stopped; Motion::finish() says why
  kShutdownRequested,  ///< the system wants the program to end within seconds
};

/// "start pressed", "cover opened", ...
std::string_view to_string(EventKind kind);

struct Event {
  TimePoint at;  ///< when it happened, not when it was delivered
  EventKind kind = EventKind::kShutdownRequested;
  /// It answers the question at hand and no other: a command that names it. A button's press names nothing, so what it answers depends on
  /// when it came.
  bool named = false;
};

/// One queue for all devices. Each event is delivered exactly once; contacts are debounced.
class Events {
 public:
  Events() = default;
  Events(const Events&) = delete;
  Events& operator=(const Events&) = delete;
  virtual ~Events() = default;

  /// Delivers the oldest undelivered event. Waits for one until `deadline`; polls if that has passed.
  /// @returns nothing if the deadline passes without an event
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<std::optional<Event>> next_event(TimePoint deadline) { return do_next_event(deadline); }

 private:
  virtual Expected<std::optional<Event>> do_next_event(TimePoint deadline) = 0;
};

}  // namespace plumbline::inline hal
