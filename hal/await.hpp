#pragma once
/// Waits for an exposure or a motion and handles the events that arrive meanwhile.

#include <chrono>
#include <concepts>

#include "hal/clock.hpp"
#include "hal/events.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

/// What await() does after an event.
enum class Waiting : std::uint8_t {
  kContinue,  ///< keep waiting
  kReturn,    ///< return to the caller, who may stop the action
};

/// Waits until `action` is over. Passes every event that arrives meanwhile to `on_event`, in order, including the action's own
/// kExposureEnded or kMotionEnded.
/// @param action    an Exposure or a Motion
/// @param on_event  Waiting(const Event&)
/// @returns whether the action is over; false only if on_event returned kReturn first
/// @retval ErrorCode::kDeviceTimeout  it was still going 1 s after ends_by()
/// @retval ErrorCode::kPowerLost
template <class Action, std::invocable<const Event&> OnEvent>
[[nodiscard]] Expected<bool> await(Action& action, Events& events, const Clock& clock, OnEvent&& on_event) {
  // Far above a device's lateness (milliseconds), short enough for a person to wait.
  constexpr auto kGrace = std::chrono::seconds(1);
  while (!action.over()) {
    const auto event = events.next_event(action.ends_by());
    if (!event) return tl::unexpected<Error>(event.error());
    if (*event) {
      if (on_event(**event) == Waiting::kReturn) return action.over();
    } else if (clock.now() > action.ends_by() + kGrace) {
      return fail(ErrorCode::kDeviceTimeout,
                  "a motion or an exposure did not end in time:\tswitch the printer off and on");
    }
  }
  return true;
}

}  // namespace plumbline::inline hal
