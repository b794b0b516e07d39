#pragma once
/// Waiting for an exposure or a motion while hearing of everything else.

#include <chrono>
#include <concepts>

#include "hal/clock.hpp"
#include "hal/events.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// What the listener of await() wants next.
enum class Waiting : std::uint8_t {
  kGoOn,   ///< wait on
  kLeave,  ///< return to the caller, who stops the action or not
};

/// Waits until `action` is over. Events that arrive meanwhile go to `on_event` in order, its own kExposureEnded or
/// kMotionEnded included.
/// @param action    an Exposure or a Motion
/// @param on_event  Waiting(const Event&)
/// @returns true: it is over; false: on_event left before
/// @retval ErrorCode::kDeviceTimeout  it was not over 1 s after it had to be
/// @retval ErrorCode::kPowerLost
template <class Action, std::invocable<const Event&> OnEvent>
[[nodiscard]] Expected<bool> await(Action& action, Events& events, const Clock& clock, OnEvent&& on_event) {
  constexpr auto kGrace = std::chrono::seconds(1);
  while (!action.over()) {
    const auto event = events.next_event(action.ends_by());
    if (!event) return tl::unexpected<Error>(event.error());
    if (*event) {
      if (on_event(**event) == Waiting::kLeave) return action.over();
    } else if (clock.now() > action.ends_by() + kGrace) {
      return fail(ErrorCode::kDeviceTimeout,
                  "a motion or an exposure did not end when it had to: switch the printer off and on");
    }
  }
  return true;
}

}  // namespace plumbline
