#pragma once
/// Waits for time, exposures and motions, and records requests that arrive meanwhile.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>

#include "firmware/print/status/print_state.hpp"
#include "hal/await.hpp"
#include "hal/machine.hpp"

namespace plumbline::firmware {

/// Requests to a print, in order of urgency.
enum class Request : std::uint8_t {
  kNone,
  kResume,  ///< start was pressed while the print waits for it
  kPause,   ///< takes effect after the layer: a layer cured in two parts would show
  kCoverOpened,
  kCancel,
  kShutdown,
};

class PrintWatch {
 public:
  /// A start that is pressed this soon after the print began to wait for one was not meant for it.
  static constexpr nanoseconds kSettle = std::chrono::seconds(1);

  /// @param state       the print's current state: events that would not change it are ignored. Must outlive this, as must the machine
  /// @param pause_came  called when somebody asks for a pause, which may take a layer to begin
  PrintWatch(Machine& machine, const PrintState& state, std::function<void()> pause_came)
      : machine_(machine), state_(state), pause_came_(std::move(pause_came)) {}

  /// The print waits for start from now on.
  void asks() { asked_at_ = machine_.clock.now(); }

  /// The most urgent request that has not been taken yet. Less urgent ones are dropped, since its effect includes theirs
  /// (an opened cover also pauses, a cancelled print needs no pause).
  Request pending() const { return pending_; }
  Request take() { return std::exchange(pending_, Request::kNone); }
  void request(Request request) { pending_ = std::max(pending_, request); }

  /// A request is pending that must not wait for the end of the layer.
  bool interrupted() const { return pending_ >= Request::kCoverOpened; }

  /// Waits for a time. @returns false: interrupted()
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<bool> wait(nanoseconds time);

  /// Waits for an Exposure or a Motion. @returns false: interrupted() before it was over; the caller stops it
  /// @retval ErrorCode::kDeviceTimeout, kPowerLost
  template <class Action>
  [[nodiscard]] Expected<bool> wait_for(Action& action) {
    return await(action, machine_.events, machine_.clock, [this](const Event& event) { return on_event(event); });
  }

 private:
  Waiting on_event(const Event& event);
  void request_if_it_matters(PrintEvent event, Request request);

  Machine& machine_;
  const PrintState& state_;
  std::function<void()> pause_came_;
  TimePoint asked_at_;
  Request pending_ = Request::kNone;
};

}  // namespace plumbline::firmware
